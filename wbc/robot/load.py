"""`load`: from a name or a path to a `Robot`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from wbc.robot.build import build
from wbc.robot.catalogue import find
from wbc.robot.packages import search_folders
from wbc.robot.robot import Robot
from wbc.robot.stated import with_stated


def load(
    name_or_path: str | Path,
    *,
    srdf: str | Path | None = None,
    left_foot: str | None = None,
    right_foot: str | None = None,
    torso: str | None = None,
    imu: str | None = None,
    nominal_posture: Mapping[str, float] | None = None,
    armature: float | Mapping[str, float] | None = None,
    sole: Mapping[str, Any] | None = None,
    fixed_joints: Iterable[str] | None = None,
    package_dirs: Iterable[str | Path] = (),
    name: str | None = None,
) -> Robot:
    """Load a robot.

    Args:
        name_or_path: a robot with a data file (`available()`), a URDF of
            example-robot-data by name (`examples()`), or the path of a URDF or
            of a robot data file.
        srdf: semantic description with a posture to stand in.
        left_foot: link that carries the left sole; guessed from the names of
            the links if they leave no doubt.
        right_foot: link that carries the right sole.
        torso: link of the upper trunk; the link from which the arms branch.
        imu: frame of the inertial unit; the base link.
        nominal_posture: joint name to position, rad or m; joints left out stay at 0.
        armature: rotor inertia at the joints, kg·m², one for all or by joint name.
        sole: `height` of the sole plane in the foot links, `length`, `width` and, if
            not zero, `center` (x, y) of its rectangle, m, in the foot links' axes; for
            feet that have no shape.
        fixed_joints: joints to weld at zero, by name or pattern (`*Finger*`).
        package_dirs: folders that hold packages, for `package://`.
        name: the robot's name.

    Raises:
        RobotNotFound: no such name and no such file.
        RobotDescriptionError: the description is malformed or makes no usable
            model; the text names the link, joint or line and the cure.
    """
    data = find(name_or_path)
    data = with_stated(
        data,
        {
            "srdf": srdf,
            "left_foot": left_foot,
            "right_foot": right_foot,
            "torso": torso,
            "imu": imu,
            "nominal_posture": nominal_posture,
            "armature": armature,
            "sole": sole,
            "fixed_joints": fixed_joints,
            "name": name,
        },
    )
    return build(data, search_folders(data.urdf, (*package_dirs, *data.package_dirs)))
