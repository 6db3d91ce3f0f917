"""Feet that were knocked off the place where they stood."""

from __future__ import annotations

import math

from wbc.gait.footsteps import other_side
from wbc.gait.phase import SWING
from wbc.gait.state import GaitState
from wbc.geometry.planar import Feet, Placement

_MOVED = 0.05  # m from where it stood from which on a foot without contact does not carry the robot
_EARLIEST = 0.03  # s of a swing after which the foot in the air may take over
_LOW = 0.03  # m over its landing place up to which it may before it has landed
_SLOW = 0.5  # m/s, the speed up to which a foot in contact stands
_THROWN = 1.2  # times √(g h), the speed from which on a foot is thrown, unless it hurries


class LostContact:
    """Finds the foot that is to carry the robot and cannot: it was knocked away.

    A blow on a leg throws its foot off the ground at some metres per second. A controller that goes
    on holding that foot, and counts on its force, lifts the other one too, which alone carries the
    robot by now. Contact alone flickers under a blow: the foot also has to be elsewhere.

    In double support it has to be elsewhere as seen from the foot that carries. The robot as a
    whole may seem to move, by centimetres when a foot that has just landed bounces. A foot that has
    not stood since it swung is late: after a push it is still on its way, and comes down. But one
    that moves at several metres per second after a usual step was hit by a blow as it landed: it
    counts as having stood. After a quick step it may be one that hurries.

    In a swing it is the support foot, and it has to be elsewhere than where it last stood in
    contact: one that has slid slowly carries the robot, and a hop of milliseconds changes nothing.

    The other one carries the robot as soon as it touches the ground; if it is almost there, it does
    so anyway, unless the support foot itself has not stood since it last swung: a swing may begin
    before the foot that carries it has landed. It may also begin right after a blow has knocked off
    the ground a foot that did stand.

    Args:
        feet: soles when the phase begins.
    """

    def __init__(self, feet: Feet) -> None:
        self._last = feet
        # Where each foot stood last, if it has stood, or was thrown, since it last swung.
        self._stood = {"left": feet.left, "right": feet.right}
        self.begin_phase(feet)

    def begin_phase(self, feet: Feet) -> None:
        """Take the soles of now as where they are when the phase begins."""
        self._at_start = feet

    def stand_anew(self, side: str, feet: Feet) -> None:
        """Take a foot as standing where it is: it has landed there after a hop."""
        self._last = feet
        self._stood[side] = feet.of(side)
        self.begin_phase(feet)

    def update(self, state: GaitState, contacts: frozenset[str] | None, dt: float) -> str | None:
        """Return the side of the foot; None if there is none, or no other one that carries.

        Args:
            state: phase, feet and support.
            contacts: sides of the soles that touch the ground; None when it is not measured.
            dt: time since the last tick, s.
        """
        if contacts is None:
            return None
        self._note_standing(state, contacts, dt)
        if state.lifted is not None or state.on_stairs:
            return None
        if state.phase is not SWING:
            return self._of_two(state.feet, *contacts) if len(contacts) == 1 else None
        side = state.support
        if side in contacts:
            return None
        stood = self._stood.get(side, self._at_start.of(side))
        moved = _distance(stood, state.stance) > _MOVED
        return side if moved and self._other_carries(state, contacts) else None

    def _note_standing(self, state: GaitState, contacts: frozenset[str], dt: float) -> None:
        last, feet = self._last, state.feet
        self._last = feet
        swing_side = state.swing_side if state.phase is SWING else None
        for side, before, now in (
            ("left", last.left, feet.left),
            ("right", last.right, feet.right),
        ):
            if side == swing_side:
                self._stood.pop(side, None)
            elif side in contacts:
                if _distance(before, now) <= _SLOW * dt:
                    self._stood[side] = now
            elif not state.is_quick:
                gait = state.normal_gait
                thrown = _THROWN * gait.omega * gait.com_height  # ω h = √(g h)
                if _distance(before, now) > thrown * dt:
                    self._stood.setdefault(side, before)

    def _of_two(self, feet: Feet, carrying: str) -> str | None:
        side = other_side(carrying)
        if side not in self._stood:
            return None
        way, way_here = (_way(self._at_start.of(s), feet.of(s)) for s in (side, carrying))
        moved = math.hypot(abs(way[0] - way_here[0]), way[1] - way_here[1]) > _MOVED
        return side if moved else None

    def _other_carries(self, state: GaitState, contacts: frozenset[str]) -> bool:
        if state.swing_side in contacts:
            return state.time >= _EARLIEST
        has_stood = state.support in self._stood
        return has_stood and state.other_foot.height - state.landing.height < _LOW


def _way(before: Placement, now: Placement) -> tuple[complex, float]:
    """Return how far a foot has moved over the ground, x + iy, and up, m."""
    return now.point - before.point, now.height - before.height


def _distance(before: Placement, now: Placement) -> float:
    across, up = _way(before, now)
    return math.hypot(across.real, across.imag, up)
