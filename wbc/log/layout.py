"""The form of one tick in memory: what crosses from the loop to the log's process."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from wbc.command import Status
from wbc.robot import Robot

CONTACTS = 8  # commanded wrenches, at the most
SUPPORT = 16  # vertices of the support polygon
FOOTSTEPS = 8
SWING = 16  # points of the swing foot's path
TEXT = 240  # bytes of explanation

STATUSES = tuple(Status)

#: Numbers that stand first, in the order in which they are written.
HEAD = (
    "time",
    "tick",
    "status",
    "phase",
    "steps",
    "estimator_time",
    "controller_time",
    "period",
    "dcm_error",
    "velocity_forward",
    "velocity_left",
    "velocity_turn",
    "text_size",
    "planned",
    "support_size",
    "footsteps_size",
    "swing_size",
)


@dataclass(frozen=True)
class Layout:
    """Sizes of a tick's record.

    All of it is float64, so that a record is written by joining arrays; a structured type
    gives every part its name.

    Attributes:
        nq: size of a configuration.
        nv: size of a velocity.
        feet: number of foot sensors.
    """

    nq: int
    nv: int
    feet: int

    @staticmethod
    def of(robot: Robot) -> Layout:
        """The layout for a robot."""
        return Layout(robot.nq, robot.nv, len(robot.soles))

    @property
    def na(self) -> int:
        """Number of joints."""
        return self.nv - 6

    @cached_property
    def body(self) -> tuple[tuple[str, int], ...]:
        """(name, size) of the arrays that every tick writes, after the head."""
        na = self.na
        return (
            ("q", self.nq),
            ("v", self.nv),
            ("tau", na),
            ("acceleration", self.nv),
            ("q_target", na),
            ("v_target", na),
            ("joint_position", na),
            ("joint_velocity", na),
            ("gyro", 3),
            ("accelerometer", 3),
            ("com", 3),
            ("dcm", 3),
            ("dcm_reference", 3),
            ("zmp", 3),
            ("true_q", self.nq),
            ("true_v", self.nv),
            ("foot_wrenches", 6 * self.feet),
            ("contacts", 7 * CONTACTS),
        )

    @cached_property
    def dtype(self) -> np.dtype[Any]:
        """Of one record."""
        plan = (
            ("support", 3 * SUPPORT),
            ("footsteps", 5 * FOOTSTEPS),
            ("swing", 3 * SWING),
            ("text", TEXT // 8),
        )
        fields: list[tuple[Any, ...]] = [(name, "f8") for name in HEAD]
        fields += [(name, "f8", (size,)) for name, size in (*self.body, *plan)]
        return np.dtype(fields)

    def slices(self, name: str) -> slice:
        """Where an array lies among a record's numbers."""
        dtype, start = self.dtype.fields[name][:2]  # type: ignore[index]
        return slice(start // 8, (start + dtype.itemsize) // 8)

    @property
    def body_slice(self) -> slice:
        """Where all arrays of `body` lie."""
        return slice(len(HEAD), len(HEAD) + sum(size for _, size in self.body))
