"""Options that complete or override what is known about a robot."""

from __future__ import annotations

import argparse
from typing import Any

from wbc.cli.parser import joint_value, number


def add_robot_option(parser: Any) -> None:
    """Add `--robot`."""
    parser.add_argument(
        "--robot",
        default="talos",
        metavar="NAME|FILE",
        help="name of a robot, or path of a URDF or robot data file (default: talos)",
    )


def add_model_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that complete a URDF, or override a robot data file."""
    group = parser.add_argument_group(
        "robot model", "These options complete a URDF, or override the data file of a robot."
    )
    group.add_argument("--left-foot", metavar="LINK", help="link that carries the left sole")
    group.add_argument("--right-foot", metavar="LINK", help="link that carries the right sole")
    group.add_argument("--torso", metavar="LINK", help="link of the upper trunk")
    group.add_argument("--imu", metavar="FRAME", help="frame of the inertial measurement unit")
    group.add_argument("--srdf", metavar="FILE", help="semantic description with a nominal posture")
    group.add_argument(
        "--posture",
        type=joint_value,
        action="append",
        metavar="JOINT=RAD",
        help="position of a joint in the nominal posture, rad (m for sliding joints); repeatable",
    )
    group.add_argument(
        "--effort-limit",
        type=joint_value,
        action="append",
        metavar="JOINT=NM",
        help="effort limit of a joint, N·m (N for sliding joints); repeatable",
    )
    group.add_argument(
        "--velocity-limit",
        type=joint_value,
        action="append",
        metavar="JOINT=RAD_S",
        help="velocity limit of a joint, rad/s (m/s for sliding joints); repeatable",
    )
    group.add_argument(
        "--armature",
        type=number,
        metavar="KG_M2",
        help="rotor inertia at every joint, kg·m²",
    )
    group.add_argument(
        "--fixed-joint",
        action="append",
        metavar="JOINT",
        help="joint to fix at zero, by name or pattern ('*finger*'); repeatable",
    )
    group.add_argument(
        "--package-dir",
        action="append",
        default=[],
        metavar="FOLDER",
        help="folder that contains the packages of package:// addresses; repeatable",
    )


def load_arguments(options: argparse.Namespace) -> dict[str, Any]:
    """Return the keyword arguments of `wbc.load` for the options of `add_model_options`."""
    return {
        "left_foot": options.left_foot,
        "right_foot": options.right_foot,
        "torso": options.torso,
        "imu": options.imu,
        "srdf": options.srdf,
        "nominal_posture": _mapping(options.posture),
        "effort_limits": _mapping(options.effort_limit),
        "velocity_limits": _mapping(options.velocity_limit),
        "armature": options.armature,
        "fixed_joints": options.fixed_joint,
        "package_dirs": options.package_dir,
    }


def _mapping(pairs: list[tuple[str, float]] | None) -> dict[str, float] | None:
    return None if pairs is None else dict(pairs)
