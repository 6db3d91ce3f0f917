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
        self._on_request = False  # whether a requested motion is being planned
        self._thread = 0  # number of the thread that plans; those before it are abandoned
        self._changed = threading.Condition()

    def start(self) -> None:
        """Start the thread."""
        threading.Thread(target=self._work, args=(self._thread,), daemon=True).start()

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

    def abandon(self) -> None:
        """Forget what was requested; if it is being planned, go on in another thread.

        A plan that takes long, or for ever, then delays no other.
        """
        with self._changed:
            self._requested = None
            if not self._on_request:
                return
            self._on_request = False
            self._thread += 1
        self.start()

    def _work(self, thread: int) -> None:
        while (taken := self._take(thread)) is not None:
            motion, standard = taken
            plan = self.cached(motion) or self._plan(motion)
            with self._changed:
                if standard:
                    self._cache[type(motion)] = plan
                abandoned = thread != self._thread
            if not abandoned:
                self._done(plan)

    def _take(self, thread: int) -> tuple[Motion, bool] | None:
        """Return the next motion, and whether nobody requested it; None in an abandoned thread."""
        with self._changed:
            if thread != self._thread:
                return None
            self._on_request = False
            while self._requested is None and not self._left:
                self._changed.wait()
                if thread != self._thread:
                    return None
            if self._requested is None:
                return self._left.pop(), True
            requested, self._requested = self._requested, None
            self._on_request = True
            return requested, False

    def _plan(self, motion: Motion) -> PlannedMotion:
        try:
            return PlannedMotion(motion, pack(motion, self._robot), "")
        except WbcError as error:
            return PlannedMotion(motion, b"", str(error))
        except Exception as error:  # a user's motion may raise anything: planning continues
            logger.exception("planning %s", motion)
            return PlannedMotion(motion, b"", f"{motion.name}: {type(error).__name__}: {error}")
