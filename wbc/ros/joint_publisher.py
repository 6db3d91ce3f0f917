"""An example node: fifteen joints that swing as in walking.

It corrects two errors of the source chapter: there, the timer period by which the phase advances
is never set, and the joint names differ from those of the published description.
"""

from __future__ import annotations

import logging
import math
from pathlib import Path
from typing import Any

from wbc.messages import message_type
from wbc.ros.node import Node
from wbc.ros.qos import LATCHED
from wbc.ros.stamp import stamp_now

logger = logging.getLogger(__name__)

_JOINT_STATE = message_type("sensor_msgs/msg/JointState")
_STRING = message_type("std_msgs/msg/String")

JOINT_NAMES = (
    "torso_yaw",
    "right_hip_pitch", "right_hip_roll", "right_knee", "right_ankle_pitch", "right_ankle_roll",
    "left_hip_pitch", "left_hip_roll", "left_knee", "left_ankle_pitch", "left_ankle_roll",
    "right_shoulder_pitch", "right_elbow",
    "left_shoulder_pitch", "left_elbow",
)  # fmt: skip
RATE_BOUNDS = (1.0, 500.0)  #: Hz


def walking_pattern(phase: float) -> tuple[float, ...]:
    """Return the joint positions, rad, in the order of `JOINT_NAMES`.

    Args:
        phase: phase of the stride, rad; the left leg lags the right one by π.
    """
    right, left = math.sin(phase), math.sin(phase + math.pi)

    def leg(swing: float) -> tuple[float, ...]:
        return (0.3 * swing, 0.1 * swing, 0.5 * max(0.0, swing), -0.3 * swing, 0.0)

    return (
        0.1 * math.sin(2.0 * phase),
        *leg(right),
        *leg(left),
        -0.2 * right,
        0.1,
        -0.2 * left,
        0.1,
    )


class JointPublisher:
    """Publishes the pattern on `joint_states`, and a robot description that has these joints.

    Args:
        node: the node; it gets the parameter `update_rate`.
        rate: initial rate of the messages, Hz.
        urdf: file to publish on `robot_description`, or None.

    Attributes:
        phase: phase of the pattern, rad.
    """

    def __init__(self, node: Node, rate: float = 50.0, urdf: Path | None = None) -> None:
        node.declare_parameter(
            "update_rate",
            float(rate),
            "rate of joint_states, Hz",
            bounds=RATE_BOUNDS,
            on_change=self._set_rate,
        )
        self._publisher = node.create_publisher(_JOINT_STATE, "joint_states")
        if urdf is not None:
            description = node.create_publisher(_STRING, "robot_description", LATCHED)
            description.publish(_STRING(data=urdf.read_text("utf-8")))
        self.phase = 0.0
        self._timer = node.create_timer(1.0 / rate, self._publish)
        logger.info("Joint publisher started at %s Hz", rate)

    def _set_rate(self, rate: float) -> None:
        self._timer.period = 1.0 / rate

    def _publish(self) -> None:
        message: Any = _JOINT_STATE(name=list(JOINT_NAMES), position=walking_pattern(self.phase))
        message.header.stamp = stamp_now()
        message.header.frame_id = "base_link"
        self._publisher.publish(message)
        self.phase = (self.phase + self._timer.period) % (2.0 * math.pi)
