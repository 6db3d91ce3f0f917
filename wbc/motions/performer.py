"""The performer: a controller that plays motions on top of the walker's balance."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence

import numpy as np

from wbc.command import Command
from wbc.errors import MotionError
from wbc.motions.body import Body
from wbc.motions.intent import Intent
from wbc.motions.motion import Motion, Script
from wbc.robot import Robot
from wbc.state import State
from wbc.telemetry import Balance, Telemetry
from wbc.walking import Walker


class Performer:
    """Plays motions one after the other; stands, balanced, when there is none.

    Args:
        robot: the robot.
        dt: control period, s.
        motions: to be played from the reset on.
        walker: balances and steps; `Walker(robot, dt)` when left out.

    Attributes:
        robot: the robot.
        dt: s.
        walker: shared balance; walking, standing and motions have one and the same.
        body: what the motions order about.
    """

    def __init__(
        self,
        robot: Robot,
        dt: float = 0.002,
        motions: Sequence[Motion] = (),
        *,
        walker: Walker | None = None,
    ) -> None:
        self.robot = robot
        self.walker = walker or Walker(robot, dt)
        self.dt = self.walker.dt
        self.body = Body(self.walker)
        self._program = tuple(motions)
        for motion in motions:
            motion.check(robot)
        self._queue: deque[Motion] = deque()
        self._playing: Motion | None = None
        self._script: Script | None = None
        self.reset(robot.standing())

    def play(self, *motions: Motion) -> None:
        """Play these after what is going on and what waits.

        Raises:
            MotionError: the robot cannot do one of them.
        """
        for motion in motions:
            motion.check(self.robot)
        self._queue.extend(motions)

    def interrupt(self, *motions: Motion) -> None:
        """Leave off at once, forget what waits, return to standing and play these.

        Raises:
            MotionError: the robot cannot do one of them.
        """
        for motion in motions:
            motion.check(self.robot)
        self._queue.clear()
        self._queue.extend(motions)
        if self._script is not None:
            self._script.close()
        self._playing, self._script = None, self.body.go_home()

    def blend(self, motion: Motion) -> None:
        """Go over to a motion at once, and forget what waits.

        What the new motion does not order goes home meanwhile; but feet come first: a lifted
        one is put down and walking ends before it begins.

        Raises:
            MotionError: the robot cannot do it.
        """
        motion.check(self.robot)
        self._queue.clear()
        if self._script is not None:
            self._script.close()
        self._playing, self._script = motion, self._over_to(motion)

    @property
    def playing(self) -> Motion | None:
        """The motion that is going on; None while it stands or returns to standing."""
        return self._playing

    @property
    def idle(self) -> bool:
        """Nothing is going on and nothing waits."""
        return self._script is None and not self._queue

    def reset(self, state: State) -> None:
        """Start anew, standing, from a state with both soles on the ground.

        Raises:
            StateError: see `State.checked`.
        """
        if self._script is not None:
            self._script.close()
        self._playing = self._script = None
        self.walker.reset(state)
        self.body.reset()
        self._queue.clear()
        self._queue.extend(self._program)

    def step(self, state: State, foot_wrenches: Mapping[str, np.ndarray] | None = None) -> Command:
        """One tick; see `Walker.step`."""
        body = self.body
        body.sense(state, foot_wrenches)
        self._go_on()
        if body.pilot is not None:
            body.time += self.dt
            command = body.pilot.step(state, foot_wrenches)
        else:
            body.advance()
            command = self.walker.step(state, foot_wrenches)
        body.observe(command)
        return command

    def _go_on(self) -> None:
        if self._script is None and self._queue:
            self._playing = self._queue.popleft()
            self._script = self._whole(self._playing)
        if self._script is None:
            return
        try:
            next(self._script)
        except StopIteration:
            self._playing = self._script = None
        except MotionError as error:  # it gives up
            self.body.note(str(error))
            self._playing, self._script = None, self.body.go_home()

    def _over_to(self, motion: Motion) -> Script:
        yield from self.body.relieve()
        self.body.relax()
        yield from self.body.stand()
        yield from self._whole(motion)

    def _whole(self, motion: Motion) -> Script:
        yield from motion.play(self.body)
        if not self.body.at_home:
            yield from self.body.go_home()

    @property
    def velocity(self) -> tuple[float, float, float]:
        """See `Walker.velocity`; motions of the arms go on while it walks."""
        return self.walker.velocity

    @velocity.setter
    def velocity(self, value: Sequence[float]) -> None:
        self.walker.velocity = value  # type: ignore[assignment]

    @property
    def intent(self) -> Intent:
        """What is promised at this tick, relative to the soles."""
        return self.body.intent()

    @property
    def balance(self) -> Balance:
        """See `Walker.balance`."""
        return (self.body.pilot or self.walker).balance

    @property
    def telemetry(self) -> Telemetry:
        """What it sees and intends, for observers."""
        return (self.body.pilot or self.walker).telemetry

    @property
    def steps(self) -> int:
        """Touchdowns since the reset."""
        return self.walker.steps

    @property
    def dcm_error(self) -> float:
        """Distance of the DCM from its reference after the last tick, m."""
        return (self.body.pilot or self.walker).dcm_error
