"""Options that complete or override what is known about a robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import wbc
from wbc.cli.argument_types import Argument, joint_value, number

Link = Annotated[str, Argument("LINK")]
JointValues = tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class ModelOptions:
    """These options complete a URDF, or override the data file of a robot.

    Attributes:
        left_foot: link that carries the left sole.
        right_foot: link that carries the right sole.
        torso: link of the upper trunk.
        imu: frame of the inertial measurement unit.
        srdf: semantic description with a nominal posture.
        nominal_posture: position of a joint in the nominal posture, rad (m for sliding joints).
        effort_limits: effort limit of a joint, N·m (N for sliding joints).
        velocity_limits: velocity limit of a joint, rad/s (m/s for sliding joints).
        armature: rotor inertia at every joint, kg·m².
        fixed_joints: joint to fix at zero, by name or pattern ('*finger*').
        package_dirs: folder that contains the packages of package:// addresses.
    """

    title: ClassVar[str] = "robot model"

    left_foot: Link | None = None
    right_foot: Link | None = None
    torso: Link | None = None
    imu: Annotated[str | None, Argument("FRAME")] = None
    srdf: Annotated[str | None, Argument("FILE")] = None
    nominal_posture: Annotated[JointValues, Argument("JOINT=RAD", joint_value, "--posture")] = ()
    effort_limits: Annotated[JointValues, Argument("JOINT=NM", joint_value, "--effort-limit")] = ()
    velocity_limits: Annotated[
        JointValues, Argument("JOINT=RAD_S", joint_value, "--velocity-limit")
    ] = ()
    armature: Annotated[float | None, Argument("KG_M2", number)] = None
    fixed_joints: Annotated[tuple[str, ...], Argument("JOINT", flag="--fixed-joint")] = ()
    package_dirs: Annotated[tuple[str, ...], Argument("FOLDER", flag="--package-dir")] = ()

    def load_arguments(self) -> dict[str, Any]:
        """Return the keyword arguments of `wbc.load`: the options that were given."""
        given = {name: value for name, value in vars(self).items() if value not in (None, ())}
        for name in given.keys() & {"nominal_posture", "effort_limits", "velocity_limits"}:
            given[name] = dict(given[name])
        return given

    def load(self, robot: str) -> wbc.Robot:
        """Load a robot by its name or path; see `wbc.load`."""
        return wbc.load(robot, **self.load_arguments())
