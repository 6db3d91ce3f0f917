"""The catalogue of topics that the ticks of a robot give, and the content of their messages."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from wbc.messages import Message, message_type
from wbc.robot import Robot
from wbc.runtime.controller_inputs import NAME as INPUTS
from wbc.runtime.record import text_of
from wbc.runtime.schema import ODOM, Column, Schema
from wbc.topics.batch import TickBatch
from wbc.topics.contact_plan import contact_plan_topics
from wbc.topics.controller_inputs import ControllerInputsTopic
from wbc.topics.link_transforms import fixed_link_transforms, moving_link_transforms
from wbc.topics.numeric import NumericTopic
from wbc.topics.topic import LatchedTopic, MessageBlock, MessageTopic, topic_name

_BASE_POSE, _BASE_TWIST, _ALL = slice(0, 7), slice(0, 6), slice(None)
_JOINTS_Q, _JOINTS_V = slice(7, None), slice(6, None)
#: Composite messages: topic, field, quantity and which of its numbers the field carries.
_COMPOSITE = (
    ("odom", "pose.pose", "q", _BASE_POSE),
    ("odom", "twist.twist", "v", _BASE_TWIST),
    ("joint_states", "position", "q", _JOINTS_Q),
    ("joint_states", "velocity", "v", _JOINTS_V),
    ("joint_states", "effort", "tau", _ALL),
    ("joint_targets", "position", "q_target", _ALL),
    ("joint_targets", "velocity", "v_target", _ALL),
    ("sensors/joint_states", "position", "joint_position", _ALL),
    ("sensors/joint_states", "velocity", "joint_velocity", _ALL),
    ("imu", "angular_velocity", "gyro", _ALL),
    ("imu", "linear_acceleration", "accelerometer", _ALL),
    ("ground_truth/odom", "pose.pose", "true_q", _BASE_POSE),
    ("ground_truth/odom", "twist.twist", "true_v", _BASE_TWIST),
    ("ground_truth/joint_states", "position", "true_q", _JOINTS_Q),
    ("ground_truth/joint_states", "velocity", "true_v", _JOINTS_V),
    ("controller_state", "tick", "tick", _ALL),
    ("controller_state", "status", "status", _ALL),
    ("controller_state", "phase", "phase", _ALL),
    ("controller_state", "steps", "steps", _ALL),
    ("controller_state", "estimator_time", "estimator_time", _ALL),
    ("controller_state", "controller_time", "controller_time", _ALL),
    ("controller_state", "period", "period", _ALL),
    ("controller_state", "dcm_error", "dcm_error", _ALL),
    ("controller_state", "velocity_forward", "velocity_command", slice(0, 1)),
    ("controller_state", "velocity_left", "velocity_command", slice(1, 2)),
    ("controller_state", "velocity_turn", "velocity_command", slice(2, 3)),
)
#: Field that carries a quantity with a topic of its own.
_FIELDS = {"numbers": "data", "point": "point", "wrench": "wrench"}


def tick_topics(schema: Schema, robot: Robot, period: float = 0.02) -> list[MessageTopic]:
    """Return all topics of a robot's ticks, except those of contacts, which may appear later.

    State, torques, wrenches and balance keep double precision. Sensor values, values that follow
    from the state and values kept for comparison have single precision: in double precision they
    would fill three quarters of a log.

    Args:
        schema: Schema of the ticks.
        robot: Robot of the ticks.
        period: Period of the transforms, sole poses and ground truth, s; 0 publishes every
            tick.
    """
    return [
        *_composite_topics(schema, robot, 0.5 * period),
        *(_quantity_topic(column) for column in schema.columns if column.message in _FIELDS),
        *(ControllerInputsTopic() for column in schema.columns if column.name == INPUTS),
        _point_topic("balance/cop", lambda batch: batch.kinematics.cop),
        *(_sole_pose_topic(sole.name, period) for sole in robot.soles),
        *contact_plan_topics(),
        moving_link_transforms(robot, period),
        *_latched_topics(robot),
    ]


def _latched_topics(robot: Robot) -> list[LatchedTopic]:
    """Return the latched topics, whose single message describes the robot."""
    urdf = robot.urdf_path.read_text("utf-8", "replace").replace("\0", "")
    description = message_type("std_msgs/msg/String")(data=urdf)
    return [fixed_link_transforms(robot), LatchedTopic("robot_description", description)]


def commanded_wrench_topic(contact: str) -> NumericTopic:
    """Return the topic of the commanded wrench from the environment on the robot at a contact."""

    def values(batch: TickBatch) -> dict[str, np.ndarray]:
        here = batch.records["contact_names"] == contact.encode()
        chosen = batch.records["contact_wrenches"][np.arange(len(batch)), here.argmax(axis=1)]
        return {"wrench": np.where(here.any(axis=1)[:, None], chosen, np.nan)}

    message = _stamped("geometry_msgs/msg/WrenchStamped", contact)
    return NumericTopic(topic_name("command", "wrench", contact), message, values)


def column_fields(column: Column) -> list[tuple[str, str]]:
    """Return the topics and fields that carry the numbers of a quantity, in their order."""
    if column.message == "composite":
        return [(topic, field) for topic, field, name, _ in _COMPOSITE if name == column.name]
    if column.message == "packed":
        return []
    return [(_column_topic(column), _FIELDS[column.message])]


def _column_topic(column: Column) -> str:
    return topic_name(*column.topic.split("/"))


def _numbers(column: Column, batch: TickBatch, part: slice = _ALL) -> np.ndarray:
    """Return a part of a column in the column's precision, shape (n, k)."""
    values: np.ndarray = batch.records[column.name].reshape(len(batch), -1)[:, part]
    return values.astype(np.float32) if column.single else values


def _composite_topics(schema: Schema, robot: Robot, truth_period: float) -> list[NumericTopic]:
    """Return the topics whose messages combine several quantities."""
    messages = {
        # Pinocchio and ROS both give the base twist in the base frame.
        "odom": _odometry(robot),
        "joint_states": _joint_state(robot, "position", "velocity", "effort"),
        "joint_targets": _joint_state(robot, "position", "velocity"),
        "sensors/joint_states": _joint_state(robot, "position", "velocity"),
        "imu": _stamped("sensor_msgs/msg/Imu", robot.imu),
        "controller_state": message_type("wbc_msgs/msg/ControllerState")(),
        "ground_truth/odom": _stamped("nav_msgs/msg/Odometry", ODOM, child_frame_id=robot.base),
        "ground_truth/joint_states": _joint_state(robot, "position", "velocity"),
    }
    topics = []
    for name, message in messages.items():
        parts = [(f, schema.column(q), part) for topic, f, q, part in _COMPOSITE if topic == name]

        def values(batch: TickBatch, parts: Any = tuple(parts)) -> dict[str, np.ndarray]:
            return {field: _numbers(column, batch, part) for field, column, part in parts}

        if name == "imu":
            values = partial(_with_orientation, values)
        kind = ControllerStateTopic if name == "controller_state" else NumericTopic
        period = truth_period if name.startswith("ground_truth/") else 0.0
        topics.append(kind(name, message, values, period))
    return topics


def _with_orientation(
    values: Callable[[TickBatch], dict[str, np.ndarray]], batch: TickBatch
) -> dict[str, np.ndarray]:
    """Return the values of an IMU with its estimated orientation, where it has measured."""
    measured = values(batch)
    known = np.isfinite(measured["angular_velocity"]).all(axis=1)
    return {**measured, "orientation": np.where(known[:, None], batch.kinematics.imu, np.nan)}


def _odometry(robot: Robot) -> Message:
    """Return the odometry of the estimator, with its typical errors as covariances.

    In walks of talos and g1 with sensor noise it drifts by 3 mm per metre; velocities are off by
    3 mm/s and 0.02 rad/s, roll and pitch by 0.002 rad (rms). Their squares, doubled and more.
    """
    message = _stamped("nav_msgs/msg/Odometry", ODOM, child_frame_id=robot.base)
    pose, twist = [1e-4] * 3 + [2e-5] * 3, [1e-4] * 3 + [1e-3] * 3  # m², rad², m²/s², rad²/s²
    message.pose.covariance = np.diag(pose).ravel()
    message.twist.covariance = np.diag(twist).ravel()
    return message


def _stamped(type_name: str, frame: str, **values: Any) -> Message:
    message = message_type(type_name)(**values)
    message.header.frame_id = frame
    return message


def _joint_state(robot: Robot, *fields: str) -> Message:
    zeros = {field: np.zeros(robot.na) for field in fields}
    return _stamped("sensor_msgs/msg/JointState", robot.base, name=robot.joint_names, **zeros)


def _quantity_topic(column: Column) -> NumericTopic:
    """Return the topic of a quantity that has a topic of its own."""
    name = _column_topic(column)
    if column.name == "com":
        return _point_topic(name, lambda batch: batch.kinematics.com)
    if column.message == "point":
        return _point_topic(name, lambda batch: _numbers(column, batch), column.frame)
    if column.message == "wrench":
        message = _stamped("geometry_msgs/msg/WrenchStamped", column.frame)
    elif column.scalar:
        message = message_type("std_msgs/msg/Float64")()
    else:
        size = column.size
        label = f"{column.name}, {column.unit}: " + ", ".join(column.labels)
        dimension = message_type("std_msgs/msg/MultiArrayDimension")
        message = message_type("std_msgs/msg/Float64MultiArray")(data=np.zeros(size))
        message.layout.dim = [dimension(label=label, size=size, stride=size)]
    field = _FIELDS[column.message]
    return NumericTopic(name, message, lambda batch: {field: _numbers(column, batch)})


def _point_topic(
    name: str, points: Callable[[TickBatch], np.ndarray], frame: str = ODOM
) -> NumericTopic:
    message = _stamped("geometry_msgs/msg/PointStamped", frame)
    return NumericTopic(name, message, lambda batch: {"point": points(batch)})


def _sole_pose_topic(sole: str, period: float) -> NumericTopic:
    message = _stamped("geometry_msgs/msg/PoseStamped", ODOM)
    name = topic_name("sole_pose", sole)
    return NumericTopic(name, message, lambda batch: {"pose": batch.kinematics.soles[sole]}, period)


class ControllerStateTopic(NumericTopic):
    """Publishes timing and status of a tick, with the explanation of a failed solve."""

    def messages(self, batch: TickBatch) -> list[MessageBlock]:
        """Return the messages of a batch; see `MessageTopic.messages`."""
        blocks = []
        for ticks, data in super().messages(batch):
            failed = batch.records["status"][ticks] != 0.0
            blocks.append(MessageBlock(ticks[~failed], data[~failed]))
            for index in np.flatnonzero(failed).tolist():
                message = message_type(self.type_name).decode(data[index])
                message.explanation = text_of(batch.records[ticks[index]])
                blocks.append(MessageBlock.of(int(ticks[index]), message.encode()))
        return [block for block in blocks if len(block.ticks)]
