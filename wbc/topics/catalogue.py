"""The catalogue of topics that the ticks of a robot give, and the content of their messages."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from wbc.messages import Message, message_type
from wbc.robot import Robot
from wbc.runtime.record import text_of
from wbc.runtime.schema import ODOM, Column, Schema
from wbc.topics.batch import TickBatch
from wbc.topics.contact_plan import (
    FootstepsTopic,
    SideFootstepsTopic,
    SupportPolygonTopic,
    SwingPathTopic,
)
from wbc.topics.latched import LatchedTopic, RobotDescription
from wbc.topics.link_transforms import FixedLinkTransforms, MovingLinkTransforms
from wbc.topics.message_topic import MessageTopic, topic_name
from wbc.topics.numeric import Columns, NumericTopic

_STATE_FIELDS = (
    "tick", "status", "phase", "steps", "estimator_time", "controller_time", "period", "dcm_error",
)  # fmt: skip
#: Maps each quantity in a composite message to the topics and fields that carry its values.
COMPOSITE_FIELDS: dict[str, tuple[tuple[str, str], ...]] = {
    "q": (("odom", "pose.pose"), ("joint_states", "position")),
    "v": (("odom", "twist.twist"), ("joint_states", "velocity")),
    "tau": (("joint_states", "effort"),),
    "q_target": (("joint_targets", "position"),),
    "v_target": (("joint_targets", "velocity"),),
    "joint_position": (("sensors/joint_states", "position"),),
    "joint_velocity": (("sensors/joint_states", "velocity"),),
    "gyro": (("sensors/imu", "angular_velocity"),),
    "accelerometer": (("sensors/imu", "linear_acceleration"),),
    "true_q": (("ground_truth/odom", "pose.pose"), ("ground_truth/joint_states", "position")),
    "true_v": (("ground_truth/odom", "twist.twist"), ("ground_truth/joint_states", "velocity")),
    "velocity_command": tuple(
        ("controller_state", f"velocity_{axis}") for axis in ("forward", "left", "turn")
    ),
    **{name: (("controller_state", name),) for name in _STATE_FIELDS},
}
_EMPTY_STRING = 5  # bytes of the CDR message

Header = message_type("std_msgs/Header")
JointState = message_type("sensor_msgs/JointState")
Odometry = message_type("nav_msgs/Odometry")


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
    declared = [_declared(column) for column in schema.columns if column.message != "composite"]
    return [
        *_composite(schema, robot, period),
        *declared,
        _point("balance/cop", lambda batch: batch.cop),
        *(_sole_pose(sole.name, period) for sole in robot.soles),
        SupportPolygonTopic(),
        FootstepsTopic(),
        SideFootstepsTopic("left"),
        SideFootstepsTopic("right"),
        SwingPathTopic(),
        MovingLinkTransforms(robot, _Every(period)),
        *latched_topics(robot),
    ]


def latched_topics(robot: Robot) -> list[LatchedTopic]:
    """Return the latched topics, whose single message describes the robot."""
    return [FixedLinkTransforms(robot), RobotDescription(robot)]


def _composite(schema: Schema, robot: Robot, period: float) -> list[MessageTopic]:
    """Return the topics whose messages combine several quantities."""
    names, base = list(robot.joint_names), robot.base

    def numbers(name: str) -> Columns:
        return _numbers(schema.column(name))

    q, v, true_q, true_v = (numbers(name) for name in ("q", "v", "true_q", "true_v"))
    truth = _KnownTruth(0.5 * period)
    effort = {"effort": numbers("tau")}
    targets = {"position": numbers("q_target"), "velocity": numbers("v_target")}
    encoders = {"position": numbers("joint_position"), "velocity": numbers("joint_velocity")}
    true_joints = {"position": _part(true_q, 7), "velocity": _part(true_v, 6)}
    joints = {"position": _part(q, 7), "velocity": _part(v, 6), **effort}
    return [
        _joint_states("joint_states", names, base, joints),
        _joint_states("joint_targets", names, base, targets),
        _odometry("odom", base, q, v),
        _joint_states("sensors/joint_states", names, base, encoders),
        _imu(robot.imu, numbers("gyro"), numbers("accelerometer")),
        ControllerStateTopic(),
        _odometry("ground_truth/odom", base, true_q, true_v, truth),
        _joint_states("ground_truth/joint_states", names, base, true_joints, truth),
    ]


def _numbers(column: Column) -> Columns:
    """Return a function that reads a column from a batch in the column's precision."""
    name = column.name
    if column.single:
        return lambda batch: batch.records[name].astype(np.float32)
    return lambda batch: batch.records[name]


def _declared(column: Column) -> NumericTopic:
    """Return the topic of a quantity that has a topic of its own."""
    if column.name == "com":
        return _point("balance/com", lambda batch: batch.com)
    numbers = _numbers(column)
    name = column_topic(column)
    if column.message == "point":
        return _point(name, numbers, column.frame)
    if column.message == "wrench":
        wrench = message_type("geometry_msgs/WrenchStamped")(header=Header(frame_id=column.frame))
        return NumericTopic(name, wrench, {"wrench": numbers}, _known(numbers))
    if column.scalar:
        number = message_type("std_msgs/Float64")()
        return NumericTopic(name, number, {"data": numbers}, _known(numbers))
    size = column.size
    array = message_type("std_msgs/Float64MultiArray")(data=np.zeros(size))
    label = f"{column.name}, {column.unit}: " + ", ".join(column.labels)
    dimension = message_type("std_msgs/MultiArrayDimension")
    array.layout.dim = [dimension(label=label, size=size, stride=size)]
    return NumericTopic(name, array, {"data": numbers}, _known(numbers))


def column_topic(column: Column) -> str:
    """Return the topic name of a quantity that has a topic of its own."""
    return topic_name(*column.topic.split("/"))


def _known(numbers: Columns) -> Columns:
    """Return a function that selects the ticks at which not all values are NaN."""

    def where(batch: TickBatch) -> np.ndarray:
        values = numbers(batch)
        return np.asarray(np.isfinite(values.reshape(len(values), -1)).any(axis=1))

    return where


def _part(numbers: Columns, start: int, stop: int | None = None) -> Columns:
    return lambda batch: numbers(batch)[:, start:stop]


def _joint_states(
    topic: str,
    names: list[str],
    base: str,
    columns: dict[str, Columns],
    where: Columns | None = None,
) -> NumericTopic:
    message = JointState(name=names, **{field: np.zeros(len(names)) for field in columns})
    message.header.frame_id = base
    return NumericTopic(topic, message, columns, where)


def _odometry(
    topic: str, base: str, q: Columns, v: Columns, where: Columns | None = None
) -> NumericTopic:
    """Return an odometry topic; Pinocchio and ROS both give the base twist in the base frame."""
    message = Odometry(header=Header(frame_id=ODOM), child_frame_id=base)
    columns = {"pose.pose": _part(q, 0, 7), "twist.twist": _part(v, 0, 6)}
    return NumericTopic(topic, message, columns, where)


def _imu(frame: str, gyro: Columns, accelerometer: Columns) -> NumericTopic:
    message = message_type("sensor_msgs/Imu")(header=Header(frame_id=frame))
    message.orientation_covariance[0] = -1.0  # by convention: the orientation is not given
    columns = {"angular_velocity": gyro, "linear_acceleration": accelerometer}
    return NumericTopic("sensors/imu", message, columns)


def _point(name: str, numbers: Columns, frame: str = ODOM) -> NumericTopic:
    message = message_type("geometry_msgs/PointStamped")(header=Header(frame_id=frame))
    return NumericTopic(name, message, {"point": numbers}, _known(numbers))


def _sole_pose(sole: str, period: float) -> NumericTopic:
    message = message_type("geometry_msgs/PoseStamped")(header=Header(frame_id=ODOM))
    return NumericTopic(
        topic_name("sole_pose", sole), message, {"pose": lambda batch: batch.soles[sole]},
        _Every(period),
    )  # fmt: skip


class _Every:
    """Selects ticks at a fixed rate.

    Args:
        period: Period, s; 0 selects all ticks.
    """

    def __init__(self, period: float) -> None:
        self._period = round(1e9 * period)
        self._due = 0

    def __call__(self, batch: TickBatch) -> np.ndarray:
        """Return a mask of the ticks of a batch that are due, shape (n,)."""
        if not self._period:
            return np.ones(len(batch), bool)
        chosen = np.zeros(len(batch), bool)
        for k, stamp in enumerate(batch.stamps.tolist()):
            if stamp >= self._due:
                chosen[k] = True
                self._due = stamp - stamp % self._period + self._period
        return chosen


class _KnownTruth:
    """Selects ticks with ground truth at a fixed rate; all topics get the same ticks.

    Args:
        period: Period, s; 0 selects all of them.
    """

    def __init__(self, period: float) -> None:
        self._every = _Every(period)
        self._answer: tuple[TickBatch | None, np.ndarray] = (None, np.empty(0, bool))

    def __call__(self, batch: TickBatch) -> np.ndarray:
        if self._answer[0] is not batch:
            known = np.isfinite(batch.records["true_q"][:, 0])
            self._answer = (batch, known & self._every(batch))
        return self._answer[1]


class ControllerStateTopic(NumericTopic):
    """Publishes timing and status of a tick, with the explanation of a failed solve."""

    def __init__(self) -> None:
        columns: dict[str, Callable[[TickBatch], np.ndarray]] = {
            name: _record_field(name) for name in _STATE_FIELDS
        }
        for i, axis in enumerate(("forward", "left", "turn")):
            velocity = _record_field("velocity_command")
            columns[f"velocity_{axis}"] = _part(velocity, i, i + 1)
        message: Message = message_type("wbc_msgs/ControllerState")()
        super().__init__("controller_state", message, columns)

    def _finish(self, batch: TickBatch, index: int, data: bytes) -> bytes:
        record = batch.records[index]
        if record["status"] == 0.0:
            return data
        text = text_of(record).encode()
        # The explanation is the last field, so its string can replace the empty one.
        final: bytes = data[:-_EMPTY_STRING] + (len(text) + 1).to_bytes(4, "little") + text + b"\0"
        return final


def _record_field(name: str) -> Columns:
    return lambda batch: batch.records[name]
