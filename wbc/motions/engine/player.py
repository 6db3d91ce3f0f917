"""The player: a controller that plays motions on top of the walker's balance."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Sequence

import numpy as np

from wbc.command import Command
from wbc.errors import MotionError
from wbc.estimation import Estimate
from wbc.motions.engine.context import MotionContext
from wbc.motions.engine.motion import Motion, Script
from wbc.motions.engine.motion_reference import MotionReference
from wbc.robot import Robot
from wbc.state import State
from wbc.telemetry import Balance, Telemetry
from wbc.walking import Walker

logger = logging.getLogger(__name__)


class MotionPlayer:
    """Plays motions one after the other; stands, balanced, when there is none.

    A motion that raises an error, or leads the CoM where the feet do not support it, is given
    up: the robot goes back to standing, and `aborted_motions` and the context's notes tell.

    Args:
        robot: the robot.
        dt: control period, s.
        motions: to be played from the reset on.
        walker: balances and steps; `Walker(robot, dt)` when left out.

    Attributes:
        robot: the robot.
        dt: s.
        walker: shared balance; walking, standing and motions have one and the same.
        context: what the motions command.
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
        self.context = MotionContext(self.walker)
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
        self._playing, self._script = None, self.context.go_home()

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
    def aborted_motions(self) -> tuple[str, ...]:
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
        self.context.reset()
        self._queue.clear()
        self._queue.extend(self._program)

    def step(self, estimate: Estimate) -> Command:
        """One tick; see `Walker.step`."""
        context = self.context
        context.sense(estimate)
        self._go_on()
        if context.override is not None:
            context.time += self.dt
            command = context.override.step(estimate)
        else:
            self._advance()
            command = self.walker.step(estimate)
        context.observe(command)
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
            self.context.advance()
        except Exception as error:
            self._give_up(error)
            self.context.home_upper_body()
            for hand in self.context.hands.values():
                hand.stay()
            self.context.advance()

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
        self.context.note(text)
        self._playing, self._script = None, self.context.go_home()

    def _over_to(self, motion: Motion) -> Script:
        context = self.context
        yield from context.release_override()
        if motion.while_walking and context.may_walk:
            context.home_upper_body()
        else:
            context.home_all()
            yield from context.stand()
        yield from self._whole(motion)

    def _whole(self, motion: Motion) -> Script:
        context = self.context
        yield from motion.play(context)
        if motion.while_walking and context.may_walk:
            yield from context.settle_upper_body()
        elif not context.at_home:
            yield from context.go_home()

    def pop_pushes(self) -> list[np.ndarray]:
        """Return the pushes that motions requested since the last call and clear them.

        Returns:
            (3,) impulses on the torso, world axes, N·s.
        """
        pushes = self.context.pushes
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
    def reference(self) -> MotionReference:
        """What is promised at this tick, relative to the soles."""
        return self.context.reference()

    @property
    def balance(self) -> Balance:
        """See `Walker.balance`."""
        return (self.context.override or self.walker).balance

    @property
    def telemetry(self) -> Telemetry:
        """What it sees and intends, for observers."""
        return (self.context.override or self.walker).telemetry

    @property
    def steps(self) -> int:
        """Touchdowns since the reset."""
        return self.walker.steps

    @property
    def dcm_error(self) -> float:
        """Distance of the DCM from its reference after the last tick, m."""
        return (self.context.override or self.walker).dcm_error
