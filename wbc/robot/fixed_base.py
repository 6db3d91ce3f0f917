"""`FixedBaseRobot`: an arm or another robot whose base does not move, and its loader."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin

from wbc.robot.couplings import couple, read_couplings, share_efforts
from wbc.robot.description import read_description
from wbc.robot.finding import Fact
from wbc.robot.inertia import add_placeholder_masses
from wbc.robot.limits import set_armature, set_limits
from wbc.robot.loader import known_joints, repaired
from wbc.robot.model import build_model
from wbc.robot.packages import search_folders
from wbc.robot.posture import starting_posture
from wbc.robot.registry import find_robot
from wbc.robot.robot_model import RobotModel
from wbc.robot.srdf import find_srdf
from wbc.robot.topology import link_of

_CENTRED_RANGE = 2.0 * np.pi  # rad: a joint that turns farther than that starts at zero


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class FixedBaseRobot(RobotModel):
    """An arm, or another robot whose base is fixed to the world; made by `load_fixed_base`.

    Configurations have the same layout as those of a robot that floats, so that tasks and limits
    work on both: `q[:7]` is the pose of the base in the world, which nothing moves, and `v[:6]`
    is zero. Put the arm elsewhere by another `q[:7]`.
    """

    def __repr__(self) -> str:
        return f"FixedBaseRobot('{self.name}', {self.na} joints on '{self.base}')"


def load_fixed_base(
    name_or_path: str | Path,
    *,
    nominal_posture: Mapping[str, float] | None = None,
    armature: float | Mapping[str, float] | None = None,
    effort_limits: Mapping[str, float] | None = None,
    velocity_limits: Mapping[str, float] | None = None,
    fixed_joints: Collection[str] | None = None,
    package_dirs: Collection[str | Path] | None = None,
    name: str | None = None,
) -> FixedBaseRobot:
    """Load a robot whose base is fixed to the world, such as an arm.

    Args:
        name_or_path: a URDF of example-robot-data by name (`wbc.robot.examples()`, e.g. "panda"),
            or the path of a URDF.
        nominal_posture: joint name to position, rad or m; when left out that of the SRDF beside
            the URDF, else the middle of each joint's range.
        armature: see `wbc.load`, as for all others.
        effort_limits: joint name to effort limit, N·m or N, in place of the URDF's.
        velocity_limits: joint name to velocity limit, rad/s or m/s, in place of the URDF's.
        fixed_joints: joints to weld at zero, by name or pattern.
        package_dirs: folders that hold packages, for `package://`.
        name: the robot's name; by default the URDF's `<robot name=…>`.

    Raises:
        RobotNotFound: no such name and no such file.
        RobotDescriptionError: an argument or the description is malformed.
    """
    data = find_robot(name_or_path).with_arguments(
        nominal_posture=nominal_posture,
        armature=armature,
        effort_limits=effort_limits,
        velocity_limits=velocity_limits,
        fixed_joints=fixed_joints,
        package_dirs=package_dirs,
        name=name,
    )
    urdf, data = read_description(data.urdf), data.without_fixed_joints()
    model = build_model(urdf, known_joints(data, urdf))
    model.name = data.name or (urdf.element.get("name") or "").strip() or urdf.path.stem
    findings = repaired(model, urdf)
    add_placeholder_masses(model)
    findings += set_limits(model, data, ())
    set_armature(model, data)
    couplings = read_couplings(urdf, model)
    share_efforts(model, couplings)
    posture = starting_posture(model, data, urdf)
    q = posture.q if posture.how else _mid_range(model)
    couple(q, couplings)
    base = link_of(model, urdf, 1)
    return FixedBaseRobot(
        name=model.name,
        model=model,
        base=base,
        q_nominal=q,
        urdf=urdf,
        srdf=data.srdf or find_srdf(data.urdf),
        package_dirs=search_folders(data.urdf, data.package_dirs),
        couplings=couplings,
        facts=(Fact("base", base, "derived", "root of the tree, fixed to the world"),),
        findings=tuple(findings),
    )


def _mid_range(model: pin.Model) -> np.ndarray:
    """Return every joint in the middle of its range; at zero where that is a turn or more."""
    q = np.asarray(pin.neutral(model))
    lower, upper = model.lowerPositionLimit[7:], model.upperPositionLimit[7:]
    limited = upper - lower < _CENTRED_RANGE
    q[7:][limited] = 0.5 * (lower[limited] + upper[limited])
    return q
