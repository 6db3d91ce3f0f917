"""Which topics a log has."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wbc.log.layout import TEXT
from wbc.log.topics.block import Block
from wbc.log.topics.fixed import FixedTopic, Numbers
from wbc.log.topics.plan import Footsteps, FootstepsOfSide, SupportPolygon, SwingPath
from wbc.log.topics.topic import Topic, TopicMessage, topic_name
from wbc.messages import Message, message_type

if TYPE_CHECKING:
    from wbc.log.order import Order

WORLD = "world"
_TF_PERIOD = 0.02  # s
_TRUTH_PERIOD = 0.01  # s
_NO_TEXT = 5  # bytes of an empty string

Header = message_type("std_msgs/Header")
JointState = message_type("sensor_msgs/JointState")
Odometry = message_type("nav_msgs/Odometry")
PointStamped = message_type("geometry_msgs/PointStamped")
TransformStamped = message_type("geometry_msgs/TransformStamped")


def topics_of(order: Order) -> list[Topic]:
    """All topics of a robot's log that are known beforehand.

    State, torques, wrenches and balance are kept bit by bit. What nobody computes with,
    because it is noise, follows from the state or is there for comparison, keeps the 24
    bits of single precision: the others would be three quarters of the file.
    """
    soles = [name for name, _ in order.soles]
    names = list(order.joints)
    q, v = _field("q"), _field("v")
    true_q, true_v = _single("true_q"), _single("true_v")
    truth = _Truth()
    return [
        _joints("/joint_states", names, _part(q, 7), _part(v, 6), _field("tau")),
        _joints("/joint_targets", names, _single("q_target"), _single("v_target")),
        _acceleration(order.layout.nv),
        _odometry("/odom", order.base, q, v),
        _joints(
            "/sensors/joint_states", names, _single("joint_position"), _single("joint_velocity")
        ),
        _imu(order.imu),
        *(_foot_wrench(i, sole) for i, sole in enumerate(soles)),
        _point("com", lambda block: block.com),
        _point("dcm", _field("dcm")),
        _point("dcm_reference", _field("dcm_reference")),
        _point("zmp", _field("zmp")),
        _point("cop", lambda block: block.cop),
        ControllerStates(),
        _odometry("/ground_truth/odom", order.base, true_q, true_v, truth),
        _joints(
            "/ground_truth/joint_states", names, _part(true_q, 7), _part(true_v, 6), where=truth
        ),
        _transforms(order.base, soles),
        SupportPolygon(),
        Footsteps(),
        FootstepsOfSide("left"),
        FootstepsOfSide("right"),
        SwingPath(),
        Description(order.description),
    ]


def _field(name: str) -> Numbers:
    return lambda block: block.records[name]


def _single(name: str) -> Numbers:
    return lambda block: block.records[name].astype(np.float32)


def _finite(numbers: Numbers) -> Numbers:
    def where(block: Block) -> np.ndarray:
        return np.asarray(np.isfinite(numbers(block)).all(axis=1))

    return where


def _part(numbers: Numbers, start: int, stop: int | None = None) -> Numbers:
    return lambda block: numbers(block)[:, start:stop]


def _joints(
    topic: str,
    names: list[str],
    position: Numbers,
    velocity: Numbers,
    effort: Numbers | None = None,
    *,
    where: Numbers | None = None,
) -> FixedTopic:
    columns = {"position": position, "velocity": velocity}
    if effort is not None:
        columns["effort"] = effort
    message = JointState(name=names, **{column: np.zeros(len(names)) for column in columns})
    return FixedTopic(topic, message, columns, where)


def _odometry(
    topic: str, base: str, q: Numbers, v: Numbers, where: Numbers | None = None
) -> FixedTopic:
    message = Odometry(header=Header(frame_id=WORLD), child_frame_id=base)
    columns = {"pose.pose": _part(q, 0, 7), "twist.twist": _part(v, 0, 6)}
    return FixedTopic(topic, message, columns, where)


def _acceleration(nv: int) -> FixedTopic:
    message = message_type("std_msgs/Float64MultiArray")(data=np.zeros(nv))
    message.layout.dim = [
        message_type("std_msgs/MultiArrayDimension")(label="acceleration", size=nv, stride=nv)
    ]
    return FixedTopic("/command/acceleration", message, {"data": _single("acceleration")})


def _imu(frame: str) -> FixedTopic:
    message = message_type("sensor_msgs/Imu")(header=Header(frame_id=frame))
    message.orientation_covariance[0] = -1.0  # ROS's sign for: no orientation is given
    columns = {"angular_velocity": _single("gyro"), "linear_acceleration": _single("accelerometer")}
    return FixedTopic("/sensors/imu", message, columns)


def _foot_wrench(index: int, sole: str) -> FixedTopic:
    message = message_type("geometry_msgs/WrenchStamped")(header=Header(frame_id=sole))
    wrench = _part(_field("foot_wrenches"), 6 * index, 6 * index + 6)
    return FixedTopic(
        topic_name("sensors", "wrench", sole),
        message,
        {"wrench": wrench},
        _finite(wrench),
    )


def _point(name: str, numbers: Numbers) -> FixedTopic:
    message = PointStamped(header=Header(frame_id=WORLD))
    return FixedTopic(
        topic_name("balance", name),
        message,
        {"point": numbers},
        _finite(numbers),
    )


def _transforms(base: str, soles: list[str]) -> FixedTopic:
    """World to base and to the soles; viewers find the other links by the joint states."""
    frames = {base: _part(_field("q"), 0, 7)}
    for sole in soles:
        frames.setdefault(sole, _sole(sole))
    header = Header(frame_id=WORLD)
    transforms = [TransformStamped(header=header, child_frame_id=frame) for frame in frames]
    columns = {f"transforms[{i}].transform": numbers for i, numbers in enumerate(frames.values())}
    message = message_type("tf2_msgs/TFMessage")(transforms=transforms)
    return FixedTopic("/tf", message, columns, _Every(_TF_PERIOD))


def _sole(name: str) -> Numbers:
    return lambda block: block.soles[name]


class _Every:
    """Chooses ticks so far apart.

    Args:
        period: s.
    """

    def __init__(self, period: float) -> None:
        self._period = round(1e9 * period)
        self._due = 0

    def __call__(self, block: Block) -> np.ndarray:
        chosen = np.zeros(len(block), bool)
        for k, stamp in enumerate(block.stamps.tolist()):
            if stamp >= self._due:
                chosen[k] = True
                self._due = stamp - stamp % self._period + self._period
        return chosen


class _Truth:
    """Chooses ticks whose truth is known, now and then; the same for all who ask."""

    def __init__(self) -> None:
        self._every = _Every(_TRUTH_PERIOD)
        self._asked: tuple[Block | None, np.ndarray] = (None, np.empty(0, bool))

    def __call__(self, block: Block) -> np.ndarray:
        if self._asked[0] is not block:
            known = np.isfinite(block.records["true_q"][:, 0])
            self._asked = (block, known & self._every(block))
        return self._asked[1]


class ControllerStates(FixedTopic):
    """Tick timing and status, with the explanation of a failed solve."""

    def __init__(self) -> None:
        names = (
            "tick", "status", "phase", "steps", "estimator_time", "controller_time", "period",
            "dcm_error", "velocity_forward", "velocity_left", "velocity_turn",
        )  # fmt: skip
        message = message_type("wbc_msgs/ControllerState")()
        super().__init__("/controller_state", message, {name: _field(name) for name in names})

    def _finish(self, block: Block, index: int, data: bytes) -> bytes:
        record = block.records[index]
        size = int(record["text_size"])
        if not size:
            return data
        whole: bytes = record["text"].tobytes()[: min(size, TEXT)]
        text = whole.decode("utf-8", "ignore").encode()
        # The explanation is the last field: a string takes the place of an empty one.
        return data[:-_NO_TEXT] + (len(text) + 1).to_bytes(4, "little") + text + b"\0"


class Description(Topic):
    """The robot's URDF, once.

    Args:
        text: the URDF.
    """

    name = "/robot_description"
    type_name = "std_msgs/msg/String"
    latched = True

    def __init__(self, text: str) -> None:
        self._message: Message | None = message_type(self.type_name)(data=text.replace("\0", ""))

    def messages(self, block: Block) -> list[TopicMessage]:
        """See `Topic.messages`."""
        message, self._message = self._message, None
        return [] if message is None or not len(block) else [TopicMessage(0, message.encode())]
