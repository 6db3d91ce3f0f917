"""The chapter's first node: fifteen joints that swing like somebody walking.

It differs from the text in what does not work there: the time goes on by the period of its timer,
which the text never sets, and its joints are those of the description that it publishes along.
"""

from __future__ import annotations

import logging
import math
import time
from pathlib import Path

from wbc.messages import message_type
from wbc.ros.node import Node
from wbc.ros.parameters import Parameters
from wbc.ros.qos import LATCHED

logger = logging.getLogger(__name__)

NAMES = (
    "torso_yaw",
    "right_hip_pitch", "right_hip_roll", "right_knee", "right_ankle_pitch", "right_ankle_roll",
    "left_hip_pitch", "left_hip_roll", "left_knee", "left_ankle_pitch", "left_ankle_roll",
    "right_shoulder_pitch", "right_elbow",
    "left_shoulder_pitch", "left_elbow",
)  # fmt: skip
DEFAULT_RATE = 50.0  #: Hz
FASTEST = 500.0  #: Hz


def pattern(t: float) -> tuple[float, ...]:
    """The joints' positions, rad, in the order of `NAMES`.

    Args:
        t: phase of the step, rad; the right leg leads, the left one follows half a turn behind.
    """
    right, left = math.sin(t), math.sin(t + math.pi)

    def leg(phase: float) -> tuple[float, ...]:
        return (0.3 * phase, 0.1 * phase, 0.5 * max(0.0, phase), -0.3 * phase, 0.0)

    return (0.1 * math.sin(2.0 * t), *leg(right), *leg(left), -0.2 * right, 0.1, -0.2 * left, 0.1)


class JointPublisher:
    """Publishes the pattern on `joint_states`, and a description that has these joints.

    Args:
        node: whose topics and parameters.
        rate: of the messages, Hz: the parameter `update_rate`.
        urdf: published on `robot_description`, if given.

    Attributes:
        parameters: `update_rate` alone; it may be changed while the node runs.
        phase: of the pattern, rad.
    """

    def __init__(self, node: Node, rate: float = DEFAULT_RATE, urdf: Path | None = None) -> None:
        self.parameters = Parameters(node)
        self._rate = self.parameters.declare(
            "update_rate", float(rate), "of the messages, Hz", lowest=1.0, highest=FASTEST
        )
        self._kind = message_type("sensor_msgs/msg/JointState")
        self._publisher = node.publisher(self._kind.type_name, "joint_states")
        if urdf is not None:
            text = message_type("std_msgs/msg/String")
            description = node.publisher(text.type_name, "robot_description", LATCHED)
            description.publish(text(data=urdf.read_text("utf-8")))
        self.phase = 0.0
        self._timer = node.timer(1.0 / self._rate.value, self._tick)
        self._rate.changed = self._change_rate
        logger.info("Joint publisher started at %s Hz", rate)

    def _change_rate(self, rate: float) -> None:
        self._timer.period = 1.0 / rate

    def _tick(self) -> None:
        message = self._kind(name=list(NAMES), position=pattern(self.phase))
        now = time.time_ns()
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(now, 1_000_000_000)
        message.header.frame_id = "base_link"
        self._publisher.publish(message)
        self.phase = (self.phase + self._timer.period) % (2.0 * math.pi)
