"""The posture that brings the hands nearest to places, of those that a robot can hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from wbc.ik.objective import PostureObjective, PostureSolution
from wbc.ik.posture_checks import MAX_TORQUE_SHARE, holding_effort, pelvis_violation
from wbc.ik.posture_ik import PostureIK
from wbc.motions.reaching.place_sampler import Places, SampledPlaces

_REACHABLE = 0.003  # m: nearer than this the posture is on the place
_HALVINGS = 6
#: Whether the CoM stays in the middle, and how dear it is to turn the trunk.
_TRIES = ((True, 1.0), (False, 1.0), (True, 10.0), (False, 10.0), (False, 100.0), (True, 1000.0))


@dataclass(frozen=True)
class ClosestPosture:
    """As near as a robot can bring its hands.

    Attributes:
        pose: whole posture.
        places: hand frame -> (3,) where the hand is to go, standing frame, m.
        said: hand frame -> what is said of a place that is out of reach.
    """

    pose: PostureSolution
    places: Places
    said: Mapping[str, str]


def closest_posture(ik: PostureIK, wished: SampledPlaces) -> ClosestPosture:
    """The posture that comes nearest to places, whatever hinders it taken into account.

    A place of which a posture is known is the hand's goal all the same. Else each hand goes as
    near as it can by itself, and both as near to that as they can together.
    """
    if wished.q is not None:
        pose, why = _posture(ik, wished)
        far = {hand: miss for hand, miss in pose.misses.items() if miss > _REACHABLE}
        said = {hand: _text(wished.places[hand], miss, why) for hand, miss in far.items()}
        return ClosestPosture(pose, wished.places, said)
    goals: dict[str, np.ndarray] = {}
    reasons: dict[str, str] = {}
    for hand, place in wished.places.items():
        pose, why = _posture(ik, SampledPlaces({hand: place}, None))
        far_off = pose.misses[hand] > _REACHABLE
        goals[hand] = ik.place(hand, pose.q) if far_off else place
        reasons[hand] = why if far_off else "the other hand's place forbids it"
    if len(goals) > 1:
        pose, _ = _posture(ik, SampledPlaces(goals, None))
    reached, said = {}, {}
    for hand, place in wished.places.items():
        reached[hand] = ik.place(hand, pose.q)
        miss = float(np.linalg.norm(place - reached[hand]))
        if miss > _REACHABLE:
            said[hand] = _text(place, miss, reasons[hand])
        else:
            reached[hand] = place
    return ClosestPosture(pose, reached, said)


def _text(place: np.ndarray, miss: float, why: str) -> str:
    at = " ".join(f"{x:.3g}" for x in place)
    return f"({at}) m is out of reach by {1e3 * miss:.0f} mm" + (f": {why}" if why else "")


@dataclass(frozen=True)
class _Candidate:
    """A posture for the hands, and what keeps the robot from it; empty when nothing does."""

    pose: PostureSolution
    hindrance: str
    holding_effort: float

    @property
    def will_do(self) -> bool:
        return not self.hindrance and self.pose.miss <= _REACHABLE


def _posture(ik: PostureIK, wished: SampledPlaces) -> tuple[PostureSolution, str]:
    """The posture that comes nearest to the places, of those that the robot can hold.

    Returns:
        The posture, and what forbids one that is on the places; empty if nothing does.
    """
    candidates = _candidates(ik, wished)
    best = min(candidates, key=lambda c: (bool(c.hindrance), c.holding_effort, c.pose.miss))
    forbidden = [c.hindrance for c in candidates if c.hindrance and c.pose.miss <= _REACHABLE]
    if best.will_do or wished.q is not None or not (best.hindrance or forbidden):
        return best.pose, best.hindrance
    short = _short_of(ik, wished.places)
    nearer = not best.hindrance and best.pose.miss < short.miss
    return best.pose if nearer else short, (forbidden or [best.hindrance])[0]


def _candidates(ik: PostureIK, wished: SampledPlaces) -> list[_Candidate]:
    """Until one will do: leaning out, or a more upright trunk where one that bows is too heavy."""
    tried: list[_Candidate] = []
    for firm_com, upright in _TRIES:
        objective = PostureObjective(
            hands=wished.places, firm_com=firm_com, upright=upright, near=wished.q
        )
        pose = ik.find(objective, wished.q)
        need = holding_effort(ik.robot, pose.q)
        heavy = f"'{need.joint}' would need {100.0 * need.ratio:.0f} % of its torque farther out"
        hindrance = heavy if need.ratio > MAX_TORQUE_SHARE else pelvis_violation(ik.robot, pose.q)
        tried.append(_Candidate(pose, hindrance, max(need.ratio - MAX_TORQUE_SHARE, 0.0)))
        if tried[-1].will_do:
            break
    return tried


def _short_of(ik: PostureIK, places: Places) -> PostureSolution:
    """On the straight way of the hands from standing to the places, as far as the robot can."""
    start = {hand: ik.place(hand, ik.home.q) for hand in places}
    best, low, high = ik.home, 0.0, 1.0
    for _ in range(_HALVINGS):
        share = 0.5 * (low + high)
        between = {hand: at + share * (places[hand] - at) for hand, at in start.items()}
        found = _candidates(ik, SampledPlaces(between, None))[-1]
        if found.will_do:
            best, low = found.pose, share
        else:
            high = share
    misses = {h: float(np.linalg.norm(p - ik.place(h, best.q))) for h, p in places.items()}
    return replace(best, misses=misses)
