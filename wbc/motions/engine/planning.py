"""Planning motions outside the loop's process, so that a tick never has to."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from wbc.errors import WbcError
from wbc.motions.engine.motion import Motion
from wbc.motions.engine.packing import pack
from wbc.robot import Robot

#: s, for `sys.setswitchinterval` of a process that plans: its other threads stay responsive.
SWITCH_INTERVAL = 2e-4

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class PlannedMotion:
    """A motion that has been checked and planned for a robot.

    Attributes:
        motion: the motion.
        packed: the motion with its plans, see `wbc.motions.pack`; empty on an error.
        error: why the robot cannot do it; empty if it can.
    """

    motion: Motion
    packed: bytes
    error: str


class MotionPlanner:
    """Plans one motion after the other, in a daemon thread that `start` starts.

    Args:
        robot: the robot that is to play the motions.
        motions: planned with default parameters when nothing is requested; the plans are cached.
        done: called with each planned motion, from that thread.
    """

    def __init__(
        self, robot: Robot, motions: Sequence[type[Motion]], done: Callable[[PlannedMotion], None]
    ) -> None:
        self._robot, self._done = robot, done
        self._cache: dict[type[Motion], PlannedMotion] = {}
        self._left = [kind() for kind in reversed(motions)]
        self._requested: Motion | None = None
        self._changed = threading.Condition()

    def start(self) -> None:
        """Start the thread."""
        threading.Thread(target=self._work, daemon=True).start()

    def cached(self, motion: Motion) -> PlannedMotion | None:
        """Return the plan of a motion if it is cached."""
        with self._changed:
            plan = self._cache.get(type(motion))
        return plan if plan is not None and plan.motion == motion else None

    def request(self, motion: Motion | None) -> None:
        """Plan this motion next, instead of the one requested before; None requests nothing."""
        with self._changed:
            self._requested = motion
            self._changed.notify()

    def _work(self) -> None:
        while True:
            motion, standard = self._take()
            plan = self.cached(motion) or self._plan(motion)
            if standard:
                with self._changed:
                    self._cache[type(motion)] = plan
            self._done(plan)

    def _take(self) -> tuple[Motion, bool]:
        with self._changed:
            while self._requested is None and not self._left:
                self._changed.wait()
            if self._requested is None:
                return self._left.pop(), True
            requested, self._requested = self._requested, None
            return requested, False

    def _plan(self, motion: Motion) -> PlannedMotion:
        try:
            return PlannedMotion(motion, pack(motion, self._robot), "")
        except WbcError as error:
            return PlannedMotion(motion, b"", str(error))
        except Exception as error:  # a user's motion may raise anything: planning continues
            logger.exception("planning %s", motion)
            return PlannedMotion(motion, b"", f"{motion.name}: {type(error).__name__}: {error}")
