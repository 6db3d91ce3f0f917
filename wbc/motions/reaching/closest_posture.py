"""The posture that brings the hands closest to positions, of those that a robot can hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from wbc.ik.objective import PostureObjective, PostureSolution
from wbc.ik.posture_checks import MAX_TORQUE_SHARE, holding_effort, pelvis_violation
from wbc.ik.posture_ik import PostureIK
from wbc.motions.reaching.place_sampler import HandPlaces, Places

_REACHED = 0.003  # m: nearer than this the hand is at the position
_BISECTIONS = 6
#: Whether the CoM stays in the middle, and how much it costs to turn the trunk; in this order.
_ATTEMPTS = (
    (True, 1.0),
    (False, 1.0),
    (True, 10.0),
    (False, 10.0),
    (False, 100.0),
    (True, 1000.0),
)


@dataclass(frozen=True)
class ClosestPosture:
    """As near as a robot can bring its hands.

    Attributes:
        posture: whole-body posture.
        places: hand frame -> (3,) where the hand is to go, standing frame, m.
        out_of_reach: hand frame -> text about a position that is out of reach.
    """

    posture: PostureSolution
    places: Places
    out_of_reach: Mapping[str, str]


def closest_posture(ik: PostureIK, desired: HandPlaces) -> ClosestPosture:
    """Return the posture that comes closest to positions, with every limit taken into account.

    A position of which a posture is known remains the hand's target in any case. Else each hand
    goes as near as it can by itself, and both as near to that as they can together.
    """
    if desired.q is not None:
        posture, why = _posture(ik, desired)
        far = {hand: error for hand, error in posture.hand_errors.items() if error > _REACHED}
        why = why or ik.limits_of_reach(posture)
        texts = {hand: _text(desired.places[hand], error, why) for hand, error in far.items()}
        return ClosestPosture(posture, desired.places, texts)
    targets: dict[str, np.ndarray] = {}
    reasons: dict[str, str] = {}
    for hand, place in desired.places.items():
        posture, why = _posture(ik, HandPlaces({hand: place}, None))
        far_off = posture.hand_errors[hand] > _REACHED
        targets[hand] = ik.frame_position(hand, posture.q) if far_off else place
        why = why or ik.limits_of_reach(posture)
        reasons[hand] = why if far_off else "the other hand's position does not allow it"
    if len(targets) > 1:
        posture, _ = _posture(ik, HandPlaces(targets, None))
    reached, texts = {}, {}
    for hand, place in desired.places.items():
        reached[hand] = ik.frame_position(hand, posture.q)
        error = float(np.linalg.norm(place - reached[hand]))
        if error > _REACHED:
            texts[hand] = _text(place, error, reasons[hand])
        else:
            reached[hand] = place
    return ClosestPosture(posture, reached, texts)


def _text(place: np.ndarray, error: float, why: str) -> str:
    at = " ".join(f"{x:.3g}" for x in place)
    return f"({at}) m is out of reach by {1e3 * error:.0f} mm: {why}"


@dataclass(frozen=True)
class _Candidate:
    """A posture for the hands, and why the robot cannot hold it; empty if it can."""

    posture: PostureSolution
    obstacle: str
    excess: float  # of the torques over what may be planned

    @property
    def acceptable(self) -> bool:
        return not self.obstacle and self.posture.hand_error <= _REACHED


def _posture(ik: PostureIK, desired: HandPlaces) -> tuple[PostureSolution, str]:
    """Return the posture closest to the positions, of those that the robot can hold.

    Returns:
        The posture, and what rules out one that is at the positions; empty if nothing does.
    """
    candidates = _candidates(ik, desired)
    best = min(candidates, key=lambda c: (bool(c.obstacle), c.excess, c.posture.hand_error))
    ruled_out = [c.obstacle for c in candidates if c.obstacle and c.posture.hand_error <= _REACHED]
    if best.acceptable or desired.q is not None or not (best.obstacle or ruled_out):
        return best.posture, best.obstacle
    short = _partial_reach(ik, desired.places)
    nearer = not best.obstacle and best.posture.hand_error < short.hand_error
    return best.posture if nearer else short, (ruled_out or [best.obstacle])[0]


def _candidates(ik: PostureIK, desired: HandPlaces) -> list[_Candidate]:
    """Return attempts until one is acceptable: leaning out, or with a more upright trunk."""
    tried: list[_Candidate] = []
    for strict_com, trunk_weight in _ATTEMPTS:
        objective = PostureObjective(
            hands=desired.places, strict_com=strict_com, trunk_weight=trunk_weight, near=desired.q
        )
        posture = ik.solve(objective, desired.q)
        effort = holding_effort(ik.robot, posture.q)
        if effort.ratio > MAX_TORQUE_SHARE:
            obstacle = (
                f"'{effort.joint}' would need {100.0 * effort.ratio:.0f} % of its torque farther "
                "out"
            )
        else:
            obstacle = pelvis_violation(ik.robot, posture.q) or _touching(ik, posture)
        excess = max(effort.ratio - MAX_TORQUE_SHARE, 0.0)
        tried.append(_Candidate(posture, obstacle, excess))
        if tried[-1].acceptable:
            break
    return tried


def _touching(ik: PostureIK, posture: PostureSolution) -> str:
    bodies = ik.self_contact(posture.q)
    return f"{bodies} would touch" if bodies else ""


def _partial_reach(ik: PostureIK, places: Places) -> PostureSolution:
    """Return a posture on the straight paths of the hands from standing, as far as possible."""
    start = {hand: ik.frame_position(hand, ik.standing.q) for hand in places}
    best, low, high = ik.standing, 0.0, 1.0
    for _ in range(_BISECTIONS):
        share = 0.5 * (low + high)
        between = {hand: at + share * (places[hand] - at) for hand, at in start.items()}
        found = _candidates(ik, HandPlaces(between, None))[-1]
        if found.acceptable:
            best, low = found.posture, share
        else:
            high = share
    errors = {h: float(np.linalg.norm(p - ik.frame_position(h, best.q))) for h, p in places.items()}
    return replace(best, hand_errors=errors)
