"""Reads a robot description in any of its languages: URDF, xacro, MJCF."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

from wbc.errors import MissingExtra, RobotDescriptionError
from wbc.robot.mjcf import urdf_of_mjcf
from wbc.robot.urdf import Urdf, parse_urdf, read_xml


def read_description(path: Path) -> Urdf:
    """Read a robot description; xacro is expanded first, and MJCF is converted to URDF.

    Raises:
        RobotDescriptionError: unreadable, malformed, or no robot description.
        MissingExtra: the file is xacro, and the package `xacro` is not installed.
    """
    root, lines = read_xml(path)
    if root.tag == "mujoco":
        return parse_urdf(path, urdf_of_mjcf(path, root), {})
    if path.suffix == ".xacro" or any(e.tag.startswith("xacro:") for e in root.iter()):
        return parse_urdf(path, _expanded(path), {})
    return parse_urdf(path, root, lines)


def _expanded(path: Path) -> ET.Element:
    try:
        import xacro
    except ImportError as error:
        raise MissingExtra("xacro", "xacro") from error
    try:
        return ET.fromstring(xacro.process_file(str(path)).toxml())
    except Exception as error:  # xacro raises whatever the file's expressions raise
        raise RobotDescriptionError(
            f"{path}: xacro cannot expand it ({type(error).__name__}: "
            f"{' '.join(str(error).split())}); expand it yourself in the environment of its "
            "packages:  xacro robot.urdf.xacro > robot.urdf"
        ) from error
