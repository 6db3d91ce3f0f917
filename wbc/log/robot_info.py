"""The properties of a robot that the analysis of a log needs."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from wbc.robot import Robot

_LIMITS = {"q_min": -np.inf, "q_max": np.inf, "v_max": np.inf, "tau_max": np.inf}


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
        feet: Links of the soles, left first.
        soles: Half length and half width of each sole, m.
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
    feet: tuple[str, ...]
    soles: tuple[tuple[float, float], ...]

    @staticmethod
    def of(robot: Robot) -> RobotInfo:
        """Return the properties of a robot."""
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
            feet=tuple(sole.link for sole in robot.soles),
            soles=tuple((sole.half_length, sole.half_width) for sole in robot.soles),
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
        values = json.loads(text)
        for name, unlimited in _LIMITS.items():
            limits = [unlimited if x is None else x for x in values[name]]
            values[name] = np.array(limits, float)
        for name in ("joints", "feet"):
            values[name] = tuple(values[name])
        values["soles"] = tuple((float(x), float(y)) for x, y in values["soles"])
        return RobotInfo(**values)
