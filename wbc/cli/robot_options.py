"""Options that say what a URDF of one's own leaves open."""

from __future__ import annotations

import argparse

import wbc


def add_robot_options(parser: argparse.ArgumentParser) -> None:
    """Feet and posture, for a URDF without a data file."""
    own = parser.add_argument_group("for a URDF of your own")
    own.add_argument("--left-foot", metavar="LINK", help="link that carries the left sole")
    own.add_argument("--right-foot", metavar="LINK", help="link that carries the right sole")
    own.add_argument("--srdf", metavar="FILE", help="brings a posture to stand in")


def stated(options: argparse.Namespace) -> dict[str, str | None]:
    """What the options state, as `wbc.load` takes it."""
    return {
        "left_foot": options.left_foot,
        "right_foot": options.right_foot,
        "srdf": options.srdf,
    }


def load_robot(name: str, options: argparse.Namespace) -> wbc.Robot:
    """The robot that the options describe.

    Raises:
        RobotNotFound: no such robot.
        RobotDescriptionError: it makes no usable model.
    """
    return wbc.load(name, **stated(options))  # type: ignore[arg-type]
