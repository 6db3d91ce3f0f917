"""Feet as estimated: contacts by side, and the reaction of the ground."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from wbc.estimation import Estimate
from wbc.gait import Feet
from wbc.gait.footsteps import SIDES
from wbc.geometry.planar import planar_rotation
from wbc.robot import Robot

_NEITHER, _LEFT, _RIGHT, _BOTH = map(frozenset, ((), SIDES[:1], SIDES[1:], SIDES))
_LEAST_LOAD = 0.8  # share of the weight below which the soles do not carry the robot


def sides_in_contact(robot: Robot, estimate: Estimate) -> frozenset[str] | None:
    """Sides whose soles stand on the ground; None without foot sensors."""
    if estimate.loads is None:
        return None
    (left, right), contacts = robot.soles, estimate.contacts
    if left.name in contacts:
        return _BOTH if right.name in contacts else _LEFT
    return _RIGHT if right.name in contacts else _NEITHER


class GroundReaction(NamedTuple):
    """Force of the ground on both soles.

    Attributes:
        cop: centre of pressure, a ground point in world axes, m.
        load: normal force, as a share of the robot's weight.
    """

    cop: complex
    load: float


def ground_reaction(
    robot: Robot, feet: Feet, wrenches: Mapping[str, np.ndarray]
) -> GroundReaction | None:
    """Return the measured force of the ground on both soles.

    The centre of pressure is `p = Σ f_z p_sole / Σ f_z` with `p_sole = (−τ_y, τ_x) / f_z` in
    each sole's axes.

    Args:
        robot: the robot.
        feet: its soles.
        wrenches: sole name -> (6,) force then moment in sole axes; N, N·m.

    Returns:
        The force; None while the soles carry less than 80 % of the weight.
    """
    load, moment = 0.0, 0j
    for sole in robot.soles:
        wrench = wrenches.get(sole.name)
        if wrench is None:
            return None
        _, _, force, roll, pitch, _ = wrench.tolist()
        if force > 0.0:
            placement = feet.of(sole.side)
            local = complex(-pitch, roll)
            moment += force * placement.point + local * planar_rotation(placement.yaw)
            load += force
    share = load / robot.weight
    return GroundReaction(moment / load, share) if share >= _LEAST_LOAD else None
