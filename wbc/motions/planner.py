"""Checks and plans motions in another process than the loop's, so that a tick never has to."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from wbc.errors import WbcError
from wbc.motions.motion import Motion
from wbc.motions.packing import pack
from wbc.robot import Robot

#: s, for `sys.setswitchinterval` of a process that plans: its other threads get through so soon.
SWITCH = 2e-4

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Plan:
    """What became of planning a motion.

    Attributes:
        motion: the motion.
        packed: it with its plans, see `wbc.motions.pack`; empty if it cannot be done.
        why: the robot cannot do it; empty if it can.
    """

    motion: Motion
    packed: bytes
    why: str


class Planner:
    """Plans one motion after the other, in a thread that nobody waits for in the end.

    It begins with `start`.

    Args:
        robot: who is to play them.
        motions: planned as they are by default, as soon as there is nothing else to do; kept.
        done: told of each plan, from that thread.
    """

    def __init__(
        self, robot: Robot, motions: Sequence[type[Motion]], done: Callable[[Plan], None]
    ) -> None:
        self._robot, self._done = robot, done
        self._kept: dict[type[Motion], Plan] = {}
        self._left = [kind() for kind in reversed(motions)]
        self._wish: Motion | None = None
        self._changed = threading.Condition()

    def start(self) -> None:
        """Begin."""
        threading.Thread(target=self._work, daemon=True).start()

    def known(self, motion: Motion) -> Plan | None:
        """The plan, if there is one already."""
        with self._changed:
            plan = self._kept.get(type(motion))
        return plan if plan is not None and plan.motion == motion else None

    def wish(self, motion: Motion | None) -> None:
        """Plan this one next, instead of what was wished for before."""
        with self._changed:
            self._wish = motion
            self._changed.notify()

    def _work(self) -> None:
        while True:
            motion, standard = self._take()
            plan = self.known(motion) or self._plan(motion)
            if standard:
                with self._changed:
                    self._kept[type(motion)] = plan
            self._done(plan)

    def _take(self) -> tuple[Motion, bool]:
        with self._changed:
            while self._wish is None and not self._left:
                self._changed.wait()
            if self._wish is None:
                return self._left.pop(), True
            wish, self._wish = self._wish, None
            return wish, False

    def _plan(self, motion: Motion) -> Plan:
        try:
            return Plan(motion, pack(motion, self._robot), "")
        except WbcError as error:
            return Plan(motion, b"", str(error))
        except Exception as error:  # a motion of somebody's own: planning goes on
            logger.exception("planning %s", motion)
            return Plan(motion, b"", f"{motion.name}: {type(error).__name__}: {error}")
