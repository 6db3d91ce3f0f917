"""The schema of a tick: how its quantities are declared, and where they lie in a record.

`wbc.runtime.quantities` declares the quantities. From their declarations follow the record in
shared memory, the topics of the log and of the ROS 2 node, the time series of the live page and
what `wbc plot --signal` draws.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from wbc.errors import WbcError, did_you_mean

if TYPE_CHECKING:
    from wbc.robot import Robot
    from wbc.runtime.tick import Tick

#: The frame of estimated positions (REP-105). The estimator starts from the plant's true state, so
#: its origin is that of the plant's world.
ODOM = "odom"
XYZ = ("x", "y", "z")
TWIST = ("vx", "vy", "vz", "wx", "wy", "wz")
WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")
_BASE_POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")

#: How a quantity travels in messages: by itself, as a type that viewers draw, or with others.
MessageKind = Literal["numbers", "point", "wrench", "composite"]


class SchemaError(WbcError):
    """A quantity is declared wrongly, or a tick does not fit the schema."""


@dataclass(frozen=True)
class Quantity:
    """Declaration of one quantity of a tick.

    Example:
        >>> power = Quantity(
        ...     "joint_power", lambda tick: tick.command.tau * tick.estimate.state.v[6:],
        ...     "mechanical power of each joint", unit="W", size="na",
        ... )
        >>> wbc.run(walker, plant, 10.0, observers=[log], quantities=[power])

    Attributes:
        name: unique, in snake case; `{sole}` in it declares one quantity per sole.
        source: where its value comes from: the path of an attribute of `Tick`, e.g.
            "command.tau", or a function of the `Tick`. With `{sole}` in the name, the path of a
            mapping by the names of soles.
        doc: what it is.
        unit: of its numbers, SI.
        size: 1 for a number; the length of an array, or "na", "nq", "nv" of the robot.
        labels: of an array's numbers; by default those of the joints or coordinates.
        frame: in which it is expressed: a ROS frame, "{base}", "{imu}" or "{sole}".
        message: "numbers": `std_msgs/Float64` or `Float64MultiArray`; "point" and "wrench":
            `geometry_msgs/PointStamped` and `WrenchStamped`; "composite": part of a message with
            other quantities, see `wbc.topics.catalogue`.
        topic: name of its topic; `wbc/<name>` by default.
        single: messages carry it in single precision, which compresses well.
    """

    name: str
    source: str | Callable[[Tick], Any]
    doc: str
    unit: str = ""
    size: int | Literal["na", "nq", "nv"] = 1
    labels: tuple[str, ...] = ()
    frame: str = ""
    message: MessageKind = "numbers"
    topic: str = ""
    single: bool = False


@dataclass(frozen=True)
class Column:
    """One quantity of a given robot's records.

    Attributes:
        name: of the quantity.
        doc: what it is.
        unit: of its numbers, SI.
        labels: one per number.
        scalar: it is a number, not an array of length 1.
        frame: ROS frame in which it is expressed; may be empty.
        message: see `Quantity`.
        topic: name of its topic, without a leading slash.
        single: see `Quantity`.
    """

    name: str
    doc: str
    unit: str
    labels: tuple[str, ...]
    scalar: bool
    frame: str
    message: MessageKind
    topic: str
    single: bool

    @property
    def size(self) -> int:
        """Number of numbers."""
        return len(self.labels)

    def label(self, index: int) -> str:
        """Name of one number with its unit, e.g. "tau: leg_left_4_joint, N·m"."""
        part = "" if self.scalar else f": {self.labels[index]}"
        return f"{self.name}{part}" + (f", {self.unit}" if self.unit else "")


#: Rows of arrays whose length varies; unused rows are NaN.
CONTACTS, SUPPORT, FOOTSTEPS, SWING = 8, 16, 16, 32
TEXT = 240  # bytes
#: What a record has besides the declared quantities: name, shape.
_BOUNDED: tuple[tuple[str, tuple[int, ...]], ...] = (
    ("contacts", (CONTACTS, 7)),  # number of the contact's name, then its wrench
    ("contact_plan_tick", ()),  # at which tick of the run the three below were computed
    ("support", (SUPPORT, 3)),
    ("footsteps", (FOOTSTEPS, 5)),  # 0 left or 1 right, x, y, z, yaw
    ("swing_path", (SWING, 3)),
)


@dataclass(frozen=True)
class Schema:
    """Where the quantities of one robot's ticks lie in a record.

    A record is an array of 64-bit words: the numbers, the arrays, what has a varying length, and
    a text. `dtype` gives them their names.

    Attributes:
        columns: of the declared quantities: numbers first, then arrays.
    """

    columns: tuple[Column, ...]

    @cached_property
    def dtype(self) -> np.dtype[Any]:
        """Structured type of a record."""
        fields: list[Any] = [
            (c.name, "f8") if c.scalar else (c.name, "f8", (c.size,)) for c in self.columns
        ]
        fields += [(name, "f8", shape) for name, shape in _BOUNDED]
        return np.dtype([*fields, ("text", f"S{TEXT}")])

    @property
    def size(self) -> int:
        """64-bit words in a record."""
        return self.dtype.itemsize // 8

    @cached_property
    def numbers(self) -> int:
        """How many columns are numbers."""
        return sum(c.scalar for c in self.columns)

    @cached_property
    def by_name(self) -> dict[str, Column]:
        """Columns by name."""
        return {c.name: c for c in self.columns}

    def column(self, name: str) -> Column:
        """Return the column of a name.

        Raises:
            SchemaError: there is none.
        """
        try:
            return self.by_name[name]
        except KeyError:
            near = did_you_mean(name, self.by_name)
            raise SchemaError(f"a tick has no quantity '{name}'{near}") from None

    def words(self, name: str) -> slice:
        """Return which words of a record a column takes."""
        dtype, start = self.dtype.fields[name][:2]  # type: ignore[index]
        return slice(start // 8, (start + dtype.itemsize) // 8)


def expanded(robot: Robot, quantities: Sequence[Quantity]) -> list[tuple[Quantity, str]]:
    """Return the quantities in the order of a record, with the sole's name where there is one.

    Raises:
        SchemaError: two quantities have the same name.
    """
    found: list[tuple[Quantity, str]] = []
    for quantity in quantities:
        per_sole = "{sole}" in quantity.name
        found += [(quantity, name) for name in _soles(robot)] if per_sole else [(quantity, "")]
    names = [quantity.name.format(sole=sole) for quantity, sole in found]
    reserved = {*dict(_BOUNDED), "text"}
    for name in names:
        if names.count(name) > 1 or name in reserved:
            raise SchemaError(f"the quantity '{name}' is declared twice; give it another name")
    return sorted(found, key=_order)


def _order(pair: tuple[Quantity, str]) -> tuple[bool, int]:
    """Numbers before arrays; attributes of ticks, of the truth, by soles, and functions."""
    quantity, sole = pair
    if callable(quantity.source):
        return quantity.size != 1, 3
    return quantity.size != 1, 2 if sole else int(quantity.source.startswith("truth."))


def schema_of(robot: Robot, quantities: Sequence[Quantity]) -> Schema:
    """Return the schema of a robot's ticks.

    Args:
        robot: the robot.
        quantities: all that a tick has.

    Raises:
        SchemaError: two quantities have the same name, or labels do not fit a size.
    """
    return Schema(tuple(_column(robot, q, sole) for q, sole in expanded(robot, quantities)))


def _column(robot: Robot, quantity: Quantity, sole: str) -> Column:
    size = quantity.size
    names = robot.joint_names
    by_size = {"na": names, "nq": (*_BASE_POSE, *names), "nv": (*TWIST, *names)}
    labels = quantity.labels
    if not labels:
        labels = by_size[size] if isinstance(size, str) else tuple(str(i) for i in range(size))
    count = len(by_size[size]) if isinstance(size, str) else size
    if len(labels) != count:
        raise SchemaError(
            f"the quantity '{quantity.name}' has {len(labels)} labels for {count} numbers"
        )
    name = quantity.name.format(sole=sole)
    return Column(
        name=name,
        doc=quantity.doc,
        unit=quantity.unit,
        labels=labels,
        scalar=size == 1,
        frame=quantity.frame.format(base=robot.base, imu=robot.imu, sole=sole),
        message=quantity.message,
        topic=(quantity.topic or f"wbc/{quantity.name}").format(sole=sole.replace("/", "_")),
        single=quantity.single,
    )


def _soles(robot: Robot) -> list[str]:
    return [sole.name for sole in robot.soles]


def columns_to_json(columns: Sequence[Column]) -> str:
    """Return columns as JSON."""
    return json.dumps([asdict(column) for column in columns], ensure_ascii=False, indent=1)


def columns_from_json(text: str) -> tuple[Column, ...]:
    """Return the columns in a text of `columns_to_json`."""
    rows = json.loads(text)
    return tuple(Column(**{**row, "labels": tuple(row["labels"])}) for row in rows)
