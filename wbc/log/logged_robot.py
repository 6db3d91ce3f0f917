"""Loads the robot of a log, for example to draw it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from wbc.errors import WbcError
from wbc.log.errors import LogError
from wbc.log.robot_info import RobotInfo
from wbc.robot import available, examples, load
from wbc.robot.description import read_description
from wbc.robot.registry import find_robot

if TYPE_CHECKING:
    from wbc.robot import Robot


def logged_robot(info: RobotInfo, name_or_path: str | Path | None = None) -> Robot:
    """Load the robot of a log.

    Args:
        info: Robot properties from the log.
        name_or_path: Robot name or URDF path, as for `load`. By default the robot of the same
            name, or the URDF at the path that the log states.

    Raises:
        LogError: The robot cannot be loaded, or its joints differ from those of the log.
    """
    source = name_or_path if name_or_path is not None else _known_name(info)
    try:
        robot = load(source) if source is not None else load(info.urdf, **_stated(info))
    except WbcError as error:
        raise LogError(
            f"the log is of robot '{info.name}', which cannot be loaded: {error}; "
            "give its name or URDF with --robot"
        ) from error
    if robot.joint_names != info.joints:
        odd = sorted(set(robot.joint_names) ^ set(info.joints))
        what = f"'{odd[0]}' and {len(odd) - 1} more" if odd else "their order"
        raise LogError(
            f"the joints of '{robot.name}' differ from those of the robot in the log ({what}); "
            "give the right robot with --robot"
        )
    return robot


def _known_name(info: RobotInfo) -> str | None:
    """Return the robot's catalogue name, or None if its URDF must be read from the logged path."""
    if info.name in available() and find_robot(info.name).urdf.name == Path(info.urdf).name:
        return info.name
    stem = Path(info.urdf).stem
    return stem if not Path(info.urdf).is_file() and stem in examples() else None


def _stated(info: RobotInfo) -> dict[str, Any]:
    """Return the arguments of `load` for a URDF that is not in the catalogue."""
    joints = [j.name for j in read_description(Path(info.urdf)).joints if j.type != "fixed"]
    fixed = [name for name in joints if name not in info.joints]
    stated: dict[str, Any] = {"name": info.name}
    if len(info.feet) > len(("left", "right")):
        stated["feet"] = info.feet
    else:
        stated["left_foot"], stated["right_foot"] = info.feet
    if fixed:
        stated["fixed_joints"] = fixed
    return stated
