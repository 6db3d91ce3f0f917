"""Checks of what a walker is asked for: a velocity, or a list of footsteps."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence

from wbc.errors import GaitError
from wbc.gait import (
    SWING,
    GaitParameters,
    GaitState,
    Placement,
    PlannedFootstep,
    Velocity,
    VelocityLimits,
)
from wbc.gait.footsteps import SIDES, clamp_footstep, other_side
from wbc.geometry.planar import ground_point, wrap_angle
from wbc.telemetry import Footstep

_TOLERANCE = 0.02  # m, rad: a foot stands this far from where it was to land
_ROUNDING = 1e-9  # of a velocity that was clamped to the limits before


class VelocityClamped(UserWarning):
    """The velocity command was beyond what the gait can do; the text says what it became."""


def parse_velocity(value: Sequence[float]) -> Velocity:
    """A velocity from three numbers: forward, left (m/s), turn left (rad/s).

    Raises:
        GaitError: it is not three finite numbers.
    """
    try:
        forward, left, turn = (float(x) for x in value)
    except (TypeError, ValueError) as error:
        raise GaitError(
            f"velocity {value!r} needs three numbers: (forward m/s, left m/s, turn left rad/s)"
        ) from error
    velocity = Velocity(forward, left, turn)
    velocity.must_be_finite()
    return velocity


def clamp_velocity(wanted: Velocity, limits: VelocityLimits, robot: str) -> Velocity:
    """Return the largest velocity within limits in the direction of one, at most that one itself.

    Warns with `VelocityClamped`, in the name of whoever sets the caller's property.

    Args:
        wanted: finite.
        limits: those of the gait.
        robot: name of the robot, for the warning.
    """
    numbers = (wanted.forward, wanted.left, wanted.turn)
    got = Velocity(*limits.clamp(*numbers))
    if limits.usage(*numbers) > 1.0 + _ROUNDING:
        warnings.warn(
            f"velocity ({wanted.forward:g} m/s, {wanted.left:g} m/s, {wanted.turn:g} rad/s) is "
            f"beyond what {robot} can do with this gait (-{limits.backward:.2f} to "
            f"{limits.forward:.2f}, ±{limits.left:.2f}, ±{limits.turn:.2f}, one at a time and less "
            f"of each together): clamped to ({got.forward:.2f}, {got.left:.2f}, {got.turn:.2f})",
            VelocityClamped,
            stacklevel=3,
        )
    return got


def parse_footsteps(footsteps: Sequence[Footstep], state: GaitState) -> list[PlannedFootstep]:
    """Footsteps that the robot can walk over from where it stands.

    Args:
        footsteps: sides alternate.
        state: feet as estimated; during a swing, the present step is completed first.

    Raises:
        GaitError: an unknown side, two steps of the same side in a row, a number that is not
            finite, or a step beyond the reach of the step before it.
    """
    _sides_must_alternate(footsteps)
    planned: list[PlannedFootstep] = []
    for k, step in enumerate(footsteps):
        x, y, z = (float(value) for value in step.position)
        if not all(map(math.isfinite, (x, y, z, step.yaw))):
            raise GaitError(
                f"footstep {k}: position {step.position} m and yaw {step.yaw} rad must be finite"
            )
        placement = Placement(ground_point(step.position), float(step.yaw), z)
        if k:
            stance, name = planned[-1].placement, f"footstep {k - 1}"
        else:
            stance, name = _stance_of_first(step.side, state), f"the {other_side(step.side)} foot"
        _must_be_within_reach(k, step.side, placement, stance, name, state.gait)
        planned.append(PlannedFootstep(step.side, placement))
    return planned


def _sides_must_alternate(footsteps: Sequence[Footstep]) -> None:
    for k, step in enumerate(footsteps):
        if step.side not in SIDES:
            raise GaitError(f"footstep {k}: side {step.side!r} is neither 'left' nor 'right'")
        if k and step.side == footsteps[k - 1].side:
            raise GaitError(
                f"footsteps {k - 1} and {k} are both '{step.side}': sides must alternate"
            )


def _stance_of_first(side: str, state: GaitState) -> Placement:
    """Return the placement of the other foot when the first footstep is made."""
    stance = other_side(side)
    if state.phase is SWING and state.lifted is None and stance == state.swing_side:
        return state.landing
    return state.feet.of(stance)


def _must_be_within_reach(
    k: int, side: str, placement: Placement, stance: Placement, name: str, gait: GaitParameters
) -> None:
    nearest = clamp_footstep(stance, side, placement, gait)
    distance = abs(nearest.point - placement.point)
    turned = wrap_angle(placement.yaw - nearest.yaw)
    if distance <= _TOLERANCE and abs(turned) <= _TOLERANCE:
        return
    local = placement.relative_to(stance)
    ahead = local.point.real + 0.0  # no minus zero
    apart = local.point.imag if side == "left" else -local.point.imag
    raise GaitError(
        f"footstep {k}: the {side} foot would stand {ahead:.2f} m ahead of {name}, "
        f"{apart:.2f} m beside it and turned by {local.yaw:.2f} rad; it reaches "
        f"±{gait.max_step:.2f} m ahead, {gait.least_width:.2f} to "
        f"{gait.greatest_width:.2f} m beside and ±{gait.max_turn:.2f} rad: "
        "give it a nearer place, or more footsteps"
    )
