"""The performer: a controller that plays motions on top of the walker's balance."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Sequence

import numpy as np

from wbc.command import Command
from wbc.errors import MotionError
from wbc.estimation import Estimate
from wbc.motions.body import Body
from wbc.motions.intent import Intent
from wbc.motions.motion import Motion, Script
from wbc.robot import Robot
from wbc.state import State
from wbc.telemetry import Balance, Telemetry
from wbc.walking import Walker

logger = logging.getLogger(__name__)


class Performer:
    """Plays motions one after the other; stands, balanced, when there is none.

    A motion that raises an error, or leads the CoM where the feet do not support it, is given
    up: the robot goes back to standing, and `given_up` and the body's notes tell.

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
            motion.prepare(robot)
        self._queue: deque[Motion] = deque()
        self._playing: Motion | None = None
        self._script: Script | None = None
        self._given_up: list[str] = []
        self.reset(robot.standing())

    def play(self, *motions: Motion) -> None:
        """Play these after what is going on and what waits.

        A motion that has not been prepared is checked and planned here, which may take a second.
        In a running loop play what has been prepared: `Motion.prepare` before the loop, or
        `wbc.motions.pack` in another process and `unpack` here. `interrupt` and `blend` likewise.

        Raises:
            MotionError: the robot cannot do one of them.
        """
        for motion in motions:
            motion.prepare(self.robot)
        self._queue.extend(motions)

    def interrupt(self, *motions: Motion) -> None:
        """Leave off at once, forget what waits, return to standing and play these.

        Raises:
            MotionError: the robot cannot do one of them.
        """
        for motion in motions:
            motion.prepare(self.robot)
        self._queue.clear()
        self._queue.extend(motions)
        if self._script is not None:
            self._script.close()
        self._playing, self._script = None, self.body.go_home()

    def blend(self, motion: Motion) -> None:
        """Go over to a motion at once, and forget what waits.

        What the new motion does not order goes home meanwhile; but feet come first: a lifted
        one is put down before it begins, and walking ends unless it is one for `while_walking`.

        Raises:
            MotionError: the robot cannot do it.
        """
        motion.prepare(self.robot)
        self._queue.clear()
        if self._script is not None:
            self._script.close()
        self._playing, self._script = motion, self._over_to(motion)

    @property
    def playing(self) -> Motion | None:
        """The motion that is going on; None while it stands or returns to standing."""
        return self._playing

    @property
    def given_up(self) -> tuple[str, ...]:
        """Names of the motions that gave up since the reset; the notes say why."""
        return tuple(self._given_up)

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
        self._given_up.clear()
        self.walker.reset(state)
        self.body.reset()
        self._queue.clear()
        self._queue.extend(self._program)

    def step(self, estimate: Estimate) -> Command:
        """One tick; see `Walker.step`."""
        body = self.body
        body.sense(estimate)
        self._go_on()
        if body.pilot is not None:
            body.time += self.dt
            command = body.pilot.step(estimate)
        else:
            self._advance()
            command = self.walker.step(estimate)
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
        except Exception as error:  # whatever a script does, the robot keeps its balance
            self._give_up(error)

    def _advance(self) -> None:
        """Move the references on; paths that a motion gave may be wrong from some time on."""
        try:
            self.body.advance()
        except Exception as error:
            self._give_up(error)
            self.body.rest()
            for hand in self.body.hands.values():
                hand.stay()
            self.body.advance()

    def _give_up(self, error: Exception) -> None:
        """The motion ends, and the body goes home; a fault of nobody's motion is raised."""
        motion, text = self._playing, str(error)
        if not isinstance(error, MotionError):
            if motion is None:
                raise error
            logger.error("the motion '%s' has a fault", motion.name, exc_info=error)
            text = f"{motion.name}: {type(error).__name__}: {error}"
        if motion is not None:
            self._given_up.append(motion.name)
        self.body.note(text)
        self._playing, self._script = None, self.body.go_home()

    def _over_to(self, motion: Motion) -> Script:
        body = self.body
        yield from body.relieve()
        if motion.while_walking and body.may_walk:
            body.rest()
        else:
            body.relax()
            yield from body.stand()
        yield from self._whole(motion)

    def _whole(self, motion: Motion) -> Script:
        body = self.body
        yield from motion.play(body)
        if motion.while_walking and body.may_walk:
            yield from body.compose()
        elif not body.at_home:
            yield from body.go_home()

    def pushes_due(self) -> list[np.ndarray]:
        """What motions ask a simulation for, see `Body.be_pushed`; each is handed out once.

        Returns:
            (3,) impulses on the torso, world axes, N·s.
        """
        pushes = self.body.pushes
        if not pushes:  # in nearly every tick; the frame takes some 20 µs
            return []
        frame = self.walker.standing_frame
        due = [self.robot.mass * (frame.rotation @ impulse) for impulse in pushes]
        pushes.clear()
        return due

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
