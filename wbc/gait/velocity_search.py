"""Search of the velocities that the leg joints allow."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wbc.gait.footsteps import Velocity
from wbc.gait.leg_workspace import LegWorkspace
from wbc.gait.speed_adaptation import FASTEST, SpeedAdaptation
from wbc.gait.step_motion import StepMotion
from wbc.gait.velocity_limits import VelocityLimits

if TYPE_CHECKING:  # which has the limits that are found here
    from wbc.gait.parameters import GaitParameters

# By how much a walk may take a joint farther beyond its limit than steps in place do.
_POSITION_SLACK, _SPEED_SLACK = 0.02, 0.1  # rad, share of the speed limit
_BISECTIONS = 6
_BACKWARD = 0.75  # share of what the joints allow: the supporting knee bears more than forward


def find_velocity_limits(
    motion: StepMotion, gait: GaitParameters, workspace: LegWorkspace
) -> VelocityLimits:
    """The velocities at which the leg joints stay within their ranges and speeds.

    What a joint is beyond already when the robot steps in place counts as its limit, and so does
    a little more, which the trunk gives by leaning.

    Args:
        motion: what walking asks of the leg joints.
        gait: timing, step width and reach, without other limits.
        workspace: workspace of the legs.
    """
    adaptation = SpeedAdaptation(gait, workspace)
    in_place = motion.excess(gait, Velocity())
    joints = len(in_place) // 2
    slack = np.repeat([_POSITION_SLACK, _SPEED_SLACK, 0.0], [joints, joints, 1])
    allowed = np.maximum(in_place + slack, 0.0)
    reach = gait.max_velocity

    def largest(direction: Velocity, low: float = 0.0) -> float:
        """The largest multiple of a velocity, from one that they allow to 1, that joints allow."""
        high, share = 1.0, 1.0
        for _ in range(_BISECTIONS):
            scaled = Velocity(
                share * direction.forward, share * direction.left, share * direction.turn
            )
            fast = adaptation.fast_share(scaled) > 0.0
            excess = motion.excess(adaptation.at(scaled), scaled, swings_arms=fast)
            if np.all(excess <= allowed):
                low = share
                if share == 1.0:
                    break
            else:
                high = share
            share = 0.5 * (low + high)
        return max(low, 0.5 ** (_BISECTIONS + 1))

    forward = reach.forward * largest(Velocity(forward=reach.forward))
    if forward == reach.forward:
        forward *= FASTEST * largest(Velocity(forward=FASTEST * reach.forward), 1.0 / FASTEST)
    return VelocityLimits(
        forward,
        _BACKWARD * reach.backward * largest(Velocity(forward=-reach.backward)),
        reach.left * largest(Velocity(left=reach.left)),
        reach.turn * largest(Velocity(turn=reach.turn)),
    )
