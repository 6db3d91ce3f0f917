"""Balance: DCM feedback, support polygons, fall detection."""

from wbc.balance.attitude import attitude, heading
from wbc.balance.com_bias import ComBias
from wbc.balance.dcm_feedback import feedback_zmp
from wbc.balance.fall import fall_reason
from wbc.balance.step_adjustment import step_shift
from wbc.balance.support import clamp_to_polygon, convex_hull, corners, near_segment

__all__ = [
    "ComBias",
    "attitude",
    "clamp_to_polygon",
    "convex_hull",
    "corners",
    "fall_reason",
    "feedback_zmp",
    "heading",
    "near_segment",
    "step_shift",
]
