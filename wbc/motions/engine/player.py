"""The motion player: a controller that plays motions on top of the walker's balance."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from wbc.command import Command
from wbc.errors import MotionError
from wbc.estimation import Estimate
from wbc.motions.engine.clock import Script
from wbc.motions.engine.context import MotionContext
from wbc.motions.engine.motion import Motion
from wbc.motions.engine.motion_reference import MotionReference
from wbc.robot import Robot
from wbc.state import State
from wbc.telemetry import ContactPlan, Telemetry
from wbc.walking import Walker

logger = logging.getLogger(__name__)

_NOTE_SHOWN = 8.0  # s


class MotionPlayer:
    """Plays motions one after the other; stands, balanced, when there is none.

    A motion that raises an error, or moves the CoM where the feet do not support it, is
    aborted: the robot returns to standing, and `aborted_motions` and the context's notes tell.
    Likewise a motion during which the robot is pushed so hard that it has to step, unless the
    motion is one for `while_walking`: balance comes first.

    A player can be copied and pickled while no script runs, and the copy continues identically.
    A script is a Python generator, which nothing can copy: while one runs the attempt raises a
    `MotionError`.

    Args:
        robot: the robot.
        dt: control period, s.
        motions: to be played from the reset on.
        walker: balances and steps; `Walker(robot, dt)` when left out.

    Attributes:
        robot: the robot.
        dt: control period, s.
        walker: the walker; walking, standing and motions share its balance.
        context: the references that motions set.

    Raises:
        MotionError: the robot cannot do one of the motions.
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
        self._aborted: list[str] = []
        self.reset(robot.standing())

    def __repr__(self) -> str:
        playing = "idle" if self.idle else f"playing {self._playing!r}"
        if self._playing is None and not self.idle:
            playing = "returning to standing" if self._script is not None else "about to play"
        waiting = f", {len(self._queue)} waiting" if self._queue else ""
        return f"MotionPlayer({self.robot.name}, dt={self.dt:g} s, {playing}{waiting})"

    def __getstate__(self) -> dict[str, Any]:
        if self._script is not None:
            name = "the return to standing" if self._playing is None else f"'{self._playing.name}'"
            raise MotionError(
                f"a motion player cannot be copied during {name}: its script is a Python "
                "generator; copy the player before the motion begins, or when it is idle"
            )
        return self.__dict__.copy()

    def play(self, *motions: Motion) -> None:
        """Play motions after the present one and those that wait.

        A motion that has not been prepared is checked and planned here, which may take a second.
        In a running loop play prepared motions: `Motion.prepare` before the loop, or
        `wbc.motions.pack` in another process and `unpack` here. `interrupt` and `blend` likewise.

        Raises:
            MotionError: the robot cannot do one of them.
        """
        for motion in motions:
            motion.prepare(self.robot)
        self._queue.extend(motions)

    def interrupt(self, *motions: Motion) -> None:
        """Stop at once, forget what waits, return to standing, and play these motions.

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
        """Change over to a motion at once, and forget what waits.

        References that the new motion does not set go home meanwhile; but feet come first: a
        lifted one is put down before the motion begins, and walking ends unless the motion is
        one for `while_walking`.

        Raises:
            MotionError: the robot cannot do it.
        """
        motion.prepare(self.robot)
        self._queue.clear()
        if self._script is not None:
            self._script.close()
        self._playing, self._script = motion, self._blend_script(motion)

    @property
    def playing(self) -> Motion | None:
        """The present motion; None while the robot stands or returns to standing."""
        return self._playing

    @property
    def aborted_motions(self) -> tuple[str, ...]:
        """Names of the motions that aborted since the reset; the notes say why."""
        return tuple(self._aborted)

    @property
    def idle(self) -> bool:
        """Whether nothing is being played and nothing waits."""
        return self._script is None and not self._queue

    def reset(self, state: State) -> None:
        """Start anew, standing, from a state with both soles on the ground.

        Raises:
            StateError: see `State.checked`.
        """
        if self._script is not None:
            self._script.close()
        self._playing = self._script = None
        self._aborted.clear()
        self.walker.reset(state)
        self.context.reset()
        self._queue.clear()
        self._queue.extend(self._program)

    def step(self, estimate: Estimate) -> Command:
        """Compute the command of one tick; see `Walker.step`."""
        context = self.context
        if self.walker.falling_why:
            self._stop_for_fall()
        context.begin_tick(estimate)
        if self.walker.about_to_recover:
            self._give_up()
        self._run_script()
        if context.override is not None:
            context.clock.advance()
            command = context.override.step(estimate)
        else:
            self._advance()
            command = self.walker.step(estimate)
        context.end_tick(command)
        return command

    def _run_script(self) -> None:
        """Run the script up to its next `yield`."""
        if self._script is None and self._queue:
            self._playing = self._queue.popleft()
            self._script = self._motion_script(self._playing)
        if self._script is None:
            return
        try:
            next(self._script)
        except StopIteration:
            self._playing = self._script = None
        except Exception as error:  # whatever a script does, the robot keeps its balance
            self._abort(error)

    def _advance(self) -> None:
        """Advance the references; a path that a motion gave may fail at any time."""
        try:
            self.context.advance()
        except Exception as error:
            self._abort(error)
            self.context.home_upper_body()
            self.context.hands.hold()
            self.context.advance()

    def _give_up(self) -> None:
        """Abort what does not combine with the steps that the walker is about to take."""
        motion, context = self._playing, self.context
        if context.override is not None or (motion is not None and motion.while_walking):
            return
        context.let_step()
        if self._script is None:
            return
        self._script.close()
        if motion is None:  # on the way back to standing, which goes on after the steps
            self._script = context.go_home()
            return
        self._abort(
            MotionError(
                f"{motion.name}: given up, because the robot has to step: the DCM is "
                f"{100.0 * self.walker.dcm_error:.0f} cm from its reference"
            )
        )

    def _abort(self, error: Exception) -> None:
        """End the motion and go home; raise an error that no motion has caused."""
        motion, text = self._playing, str(error)
        if not isinstance(error, MotionError):
            if motion is None:
                raise error
            logger.error("the motion '%s' raised an error", motion.name, exc_info=error)
            text = f"{motion.name}: {type(error).__name__}: {error}"
        if motion is not None:
            self._aborted.append(motion.name)
        self.context.note(text)
        self._playing, self._script = None, self.context.go_home()

    def _stop_for_fall(self) -> None:
        """Give up what plays and waits: the walker follows nothing any more until its reset."""
        if self._playing is not None:
            self._aborted.append(self._playing.name)
            self.context.note(f"{self._playing.name}: the robot falls")
        if self._script is not None:
            self._script.close()
        self._queue.clear()
        self._playing = self._script = None

    def _motion_script(self, motion: Motion) -> Script:
        """Return the script of a motion, and of what brings home what the motion does not."""
        context = self.context
        yield from motion.play(context)
        if motion.while_walking and context.stance.may_walk:
            yield from context.settle_upper_body()
        elif not context.at_home:
            yield from context.go_home()

    def _blend_script(self, motion: Motion) -> Script:
        """Return the script that changes over to a motion."""
        context = self.context
        yield from context.release_override()
        if motion.while_walking and context.stance.may_walk:
            context.home_upper_body()
        else:
            context.home_all()
            yield from context.feet.stand()
        yield from self._motion_script(motion)

    def pop_pushes(self) -> list[np.ndarray]:
        """Return the pushes that motions requested since the last call, and clear them.

        Returns:
            (3,) impulses on the torso, world axes, N·s; see `MotionContext.request_push`.
        """
        pushes = self.context.pushes
        if not pushes:  # in nearly every tick; the standing frame takes some 20 µs
            return []
        frame = self.walker.standing_frame
        impulses = [self.robot.mass * (frame.rotation @ impulse) for impulse in pushes]
        pushes.clear()
        return impulses

    def pop_payloads(self) -> list[tuple[str, float]]:
        """Return the payloads that motions requested since the last call, and clear them.

        Returns:
            Frame of the hand, and mass, kg; 0 takes it away. See `MotionContext.request_payload`.
        """
        payloads = list(self.context.payloads)
        self.context.payloads.clear()
        return payloads

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Commanded walking velocity, see `Walker.velocity`; motions of the arms continue."""
        return self.walker.velocity

    @velocity.setter
    def velocity(self, value: Sequence[float]) -> None:
        self.walker.velocity = value  # type: ignore[assignment]

    @property
    def reference(self) -> MotionReference:
        """The references at this tick, relative to the soles."""
        return self.context.reference()

    @property
    def telemetry(self) -> Telemetry:
        """Status of the walker, or of the override that replaces it, with this player's text."""
        override, text = self.context.override, self.status_text
        if override is None:
            telemetry = self.walker.telemetry
            if self.walker.falling_why or not text:
                return telemetry
            return replace(telemetry, status_text=text)
        steps = self.walker.steps
        return replace(override.telemetry, steps=steps, status_text=text)

    @property
    def contact_plan(self) -> ContactPlan:
        """See `Walker.contact_plan`."""
        return (self.context.override or self.walker).contact_plan

    @property
    def status_text(self) -> str:
        """The motion that plays, or the latest note for a few seconds; empty while it stands."""
        if self._playing is not None:
            return self._playing.name
        context = self.context
        if context.notes and context.clock.time - context.note_time < _NOTE_SHOWN:
            return context.notes[-1]
        return "" if self.idle else "returning to standing"

    @property
    def steps(self) -> int:
        """Number of touchdowns since the reset."""
        return self.walker.steps

    @property
    def dcm_error(self) -> float:
        """Distance of the DCM from its reference after the last tick, m."""
        return (self.context.override or self.walker).dcm_error
