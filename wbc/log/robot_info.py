"""The properties of a robot that the analysis of a log needs."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from wbc.robot import Robot


@dataclass(frozen=True, eq=False)
class RobotInfo:
    """The properties of a robot that the analysis of its log needs, without its model.

    Attributes:
        name: Name of the robot.
        urdf: Path of the URDF on the machine that wrote the log.
        joints: Joint names, length na.
        q_min: Lower position limits, rad or m, shape (na,).
        q_max: Upper position limits, rad or m, shape (na,).
        v_max: Velocity limits, rad/s or m/s, shape (na,).
        tau_max: Torque limits, N·m or N, shape (na,).
        base: Name of the root link.
        mass: Total mass, kg.
        weight: Weight, N.
        feet: Links of the left and right sole.
        soles: Half length and half width of the left and right sole, m.
    """

    name: str
    urdf: str
    joints: tuple[str, ...]
    q_min: np.ndarray
    q_max: np.ndarray
    v_max: np.ndarray
    tau_max: np.ndarray
    base: str
    mass: float
    weight: float
    feet: tuple[str, str]
    soles: tuple[tuple[float, float], tuple[float, float]]

    @staticmethod
    def of(robot: Robot) -> RobotInfo:
        """Return the properties of a robot."""
        left, right = robot.soles
        return RobotInfo(
            name=robot.name,
            urdf=str(robot.urdf_path),
            joints=robot.joint_names,
            q_min=robot.q_min,
            q_max=robot.q_max,
            v_max=robot.v_max,
            tau_max=robot.tau_max,
            base=robot.base,
            mass=robot.mass,
            weight=robot.weight,
            feet=(left.link, right.link),
            soles=((left.half_length, left.half_width), (right.half_length, right.half_width)),
        )

    def to_json(self) -> str:
        """Return JSON; infinite limits are null."""
        table = {
            name: [x if np.isfinite(x) else None for x in value.tolist()]
            if isinstance(value, np.ndarray)
            else value
            for name, value in vars(self).items()
        }
        return json.dumps(table, indent=1)

    @staticmethod
    def from_json(text: str) -> RobotInfo:
        """Return the properties from the output of `to_json`."""
        table = json.loads(text)
        limits = {
            name: np.array([sign * np.inf if x is None else x for x in table[name]], float)
            for name, sign in (("q_min", -1), ("q_max", 1), ("v_max", 1), ("tau_max", 1))
        }
        left, right = ((float(x), float(y)) for x, y in table["soles"])
        return RobotInfo(
            name=str(table["name"]),
            urdf=str(table["urdf"]),
            joints=tuple(table["joints"]),
            **limits,
            base=str(table["base"]),
            mass=float(table["mass"]),
            weight=float(table["weight"]),
            feet=(str(table["feet"][0]), str(table["feet"][1])),
            soles=(left, right),
        )
