"""The robot of a log, loaded anew: for whoever wants to draw it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from wbc.errors import WbcError
from wbc.log.errors import LogError
from wbc.log.sheet import RobotSheet
from wbc.robot import available, examples, load
from wbc.robot.registry import find_robot
from wbc.robot.urdf import read_urdf

if TYPE_CHECKING:
    from wbc.robot import Robot


def robot_of(sheet: RobotSheet, name_or_path: str | Path | None = None) -> Robot:
    """The robot that a log is of.

    Args:
        sheet: from the log.
        name_or_path: as `load` takes it; when left out, the robot of the same name, or the
            URDF where it was when it was logged.

    Raises:
        LogError: that robot is not there, or has other joints than the log.
    """
    source = name_or_path if name_or_path is not None else _known_name(sheet)
    try:
        robot = load(source) if source is not None else load(sheet.urdf, **_stated(sheet))
    except WbcError as error:
        raise LogError(
            f"the log is of '{sheet.name}', which cannot be loaded: {error}; "
            "say where it is with --robot"
        ) from error
    if robot.joint_names != sheet.joints:
        odd = sorted(set(robot.joint_names) ^ set(sheet.joints))
        what = f"'{odd[0]}' and {len(odd) - 1} more" if odd else "their order"
        raise LogError(
            f"'{robot.name}' has other joints than the robot of the log ({what}); "
            "say which robot it is with --robot"
        )
    return robot


def _known_name(sheet: RobotSheet) -> str | None:
    """The name by which `load` finds the robot, or None: its URDF has to be read where it was."""
    if sheet.name in available() and find_robot(sheet.name).urdf.name == Path(sheet.urdf).name:
        return sheet.name
    stem = Path(sheet.urdf).stem
    return stem if not Path(sheet.urdf).is_file() and stem in examples() else None


def _stated(sheet: RobotSheet) -> dict[str, Any]:
    """What `load` has to be told about a URDF of one's own."""
    left, right = sheet.feet
    joints = [j.name for j in read_urdf(Path(sheet.urdf)).joints if j.type != "fixed"]
    fixed = [name for name in joints if name not in sheet.joints]
    stated: dict[str, Any] = {"left_foot": left, "right_foot": right, "name": sheet.name}
    if fixed:
        stated["fixed_joints"] = fixed
    return stated
