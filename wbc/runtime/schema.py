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
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from wbc.errors import WbcError, did_you_mean
from wbc.runtime.record import VARYING_FIELDS

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
MessageKind = Literal["numbers", "point", "wrench", "composite", "packed"]


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
        source: origin of its value: the path of an attribute of `Tick`, e.g.
            "command.tau", or a function of the `Tick`, which returns NaN where it is unknown. With
            `{sole}` in the name, the path of a mapping by the names of soles.
        doc: meaning.
        unit: SI unit of its numbers.
        size: 1 for a number; the length of an array, or "na", "nq", "nv" of the robot.
        labels: names of an array's numbers; by default those of the joints or coordinates.
        frame: frame in which it is expressed: a ROS frame, "{base}", "{imu}" or "{sole}".
        message: "numbers": `std_msgs/Float64` or `Float64MultiArray`; "point" and "wrench":
            `geometry_msgs/PointStamped` and `WrenchStamped`; "composite": part of a message with
            other quantities, see `wbc.topics.catalogue`; "packed": no numbers to be plotted, with
            a topic of its own kind.
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
        name: name of the quantity.
        doc: meaning.
        unit: SI unit of its numbers.
        labels: one per number.
        scalar: whether it is a number instead of an array of length 1.
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
        """Number of elements."""
        return len(self.labels)

    def label(self, index: int) -> str:
        """Name of one number with its unit, e.g. "tau: leg_left_4_joint, N·m"."""
        part = "" if self.scalar else f": {self.labels[index]}"
        return f"{self.name}{part}" + (f", {self.unit}" if self.unit else "")


@dataclass(frozen=True)
class Schema:
    """The layout of one robot's quantities in a record.

    A record consists of the declared quantities and then of the fields of `wbc.runtime.record`,
    whose length varies. `dtype` gives all of them their names.

    Attributes:
        columns: columns of the declared quantities, in the order of a record.
    """

    columns: tuple[Column, ...]

    @cached_property
    def dtype(self) -> np.dtype[Any]:
        """Structured type of a record; its size is a multiple of 8 bytes."""
        fields = [(c.name, "f8", () if c.scalar else (c.size,)) for c in self.columns]
        return np.dtype([*fields, *VARYING_FIELDS])

    @property
    def size(self) -> int:
        """64-bit words in a record."""
        return self.dtype.itemsize // 8

    @cached_property
    def numbers(self) -> tuple[Column, ...]:
        """Columns of numbers that can be plotted; the packed ones follow them."""
        return tuple(column for column in self.columns if column.message != "packed")

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


def declared_columns(
    robot: Robot, quantities: Sequence[Quantity]
) -> list[tuple[Column, str | Callable[[Tick], Any]]]:
    """Return the columns and sources of a robot's quantities in the order of a record.

    Attributes of ticks come first, numbers before arrays, then functions, and packed ones last.

    Args:
        robot: the robot.
        quantities: all that a tick has.

    Raises:
        SchemaError: two quantities have the same name, labels do not fit a size, or the source of a
            quantity per sole is a function.
    """
    columns: list[tuple[Column, str | Callable[[Tick], Any]]] = []
    for quantity in quantities:
        if "{sole}" in quantity.name:
            for sole in robot.soles:
                source = _value_of_sole(quantity, sole.name)
                columns.append((_column(robot, quantity, sole.name), source))
        else:
            columns.append((_column(robot, quantity), quantity.source))
    names = [column.name for column, _ in columns] + [field[0] for field in VARYING_FIELDS]
    for name in names:
        if names.count(name) > 1:
            raise SchemaError(f"the quantity '{name}' is declared twice; give it another name")
    return sorted(
        columns, key=lambda c: (c[0].message == "packed", callable(c[1]), not c[0].scalar)
    )


def _value_of_sole(quantity: Quantity, sole: str) -> Callable[[Tick], Any]:
    if not isinstance(quantity.source, str):
        raise SchemaError(
            f"the source of the quantity '{quantity.name}' must be the path of a mapping by the "
            "names of soles; declare a quantity per sole to compute it by a function"
        )
    mapping = attrgetter(quantity.source)
    return lambda tick: mapping(tick).get(sole, np.nan)


def _column(robot: Robot, quantity: Quantity, sole: str = "") -> Column:
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


def columns_to_json(columns: Sequence[Column]) -> str:
    """Return columns as JSON."""
    return json.dumps([asdict(column) for column in columns], ensure_ascii=False, indent=1)


def columns_from_json(text: str) -> tuple[Column, ...]:
    """Return the columns in a text of `columns_to_json`."""
    rows = json.loads(text)
    return tuple(Column(**{**row, "labels": tuple(row["labels"])}) for row in rows)
