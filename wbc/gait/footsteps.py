"""The next footstep: from a velocity command or from a given list."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from wbc.errors import GaitError
from wbc.geometry.planar import Feet, Placement, planar_rotation, wrap_angle

if TYPE_CHECKING:  # which finds its limits by means of this module
    from wbc.gait.parameters import GaitParameters

SIDES = ("left", "right")


def other_side(side: str) -> str:
    """The other side."""
    return "right" if side == "left" else "left"


def lateral_sign(side: str) -> float:
    """+1 for the left foot, −1 for the right: the sign of its y in the body."""
    return 1.0 if side == "left" else -1.0


@dataclass(frozen=True, slots=True)
class Velocity:
    """Walking velocity in the heading frame: forward, left (m/s), turn left (rad/s)."""

    forward: float = 0.0
    left: float = 0.0
    turn: float = 0.0

    @property
    def is_zero(self) -> bool:
        """No motion asked for."""
        return self.forward == 0.0 and self.left == 0.0 and self.turn == 0.0

    @property
    def speed(self) -> float:
        """Speed over the ground, m/s."""
        return math.hypot(self.forward, self.left)

    def must_be_finite(self) -> None:
        """Check the entries.

        Raises:
            GaitError: an entry is not finite.
        """
        wanted = (self.forward, self.left, self.turn)
        if not all(map(math.isfinite, wanted)):
            raise GaitError(
                f"velocity {wanted} must be finite: (forward m/s, left m/s, turn left rad/s)"
            )

    def clamped(self, gait: GaitParameters) -> Velocity:
        """The largest velocity within the gait's limits in the same direction; at most itself.

        Raises:
            GaitError: an entry is not finite.
        """
        self.must_be_finite()
        return Velocity(*gait.max_velocity.clamp(self.forward, self.left, self.turn))


def first_swing_side(feet: Feet, velocity: Velocity) -> str:
    """The side that takes the first step out of standing."""
    way = velocity.left or velocity.turn
    for side in SIDES:
        if lateral_sign(side) * way > 0.0:
            return side
    # Forward: the foot that is behind, in the direction of travel.
    ahead = feet.left.to_local(feet.right.point).real * velocity.forward
    return "left" if ahead > 0.01 else "right"


def next_footstep(
    stance: Placement, swing_side: str, velocity: Velocity, gait: GaitParameters
) -> Placement:
    """Landing place of the swing foot for one step at a velocity.

    The point midway between the feet moves on by the velocity; sideways and turning,
    only the foot on that side makes way (twice as much) and the other one closes, so
    that the feet never cross.
    """
    sign = lateral_sign(swing_side)
    T = gait.step_duration
    leads = sign * velocity.left > 0.0
    side = 2.0 * velocity.left * T if leads else 0.0
    leads = sign * velocity.turn > 0.0
    yaw = 2.0 * velocity.turn * T if leads else 0.0
    middle = complex(0.0, sign * 0.5 * gait.step_width)
    turned = planar_rotation(yaw)
    # Forward motion along the mean heading of the step.
    forward = velocity.forward * T * planar_rotation(0.5 * yaw)
    local = middle + forward + (middle + complex(0.0, side)) * turned
    return Placement(stance.to_world(local), wrap_angle(stance.yaw + yaw), stance.height)


def clamp_footstep(
    stance: Placement, swing_side: str, wanted: Placement, gait: GaitParameters
) -> Placement:
    """The nearest landing place that the leg reaches and that keeps the feet apart."""
    sign = lateral_sign(swing_side)
    local = stance.to_local(wanted.point)
    forward = max(-gait.max_step, min(gait.max_step, local.real))
    width = max(gait.least_width, min(gait.greatest_width, sign * local.imag))
    yaw = max(-gait.max_turn, min(gait.max_turn, wrap_angle(wanted.yaw - stance.yaw)))
    point = stance.to_world(complex(forward, sign * width))
    return Placement(point, wrap_angle(stance.yaw + yaw), wanted.height)


def are_square(left: Placement, right: Placement, gait: GaitParameters) -> bool:
    """The feet stand side by side, as after a completed stop."""
    local = left.to_local(right.point)
    return (
        abs(local.real) < 0.02
        and abs(-local.imag - gait.step_width) < 0.03
        and abs(wrap_angle(right.yaw - left.yaw)) < 0.05
    )
