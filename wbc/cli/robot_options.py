"""Options that say what a URDF of one's own leaves open."""

from __future__ import annotations

import argparse
from typing import Any


def add_robot_options(parser: argparse.ArgumentParser) -> None:
    """Feet and posture, for a URDF without a data file."""
    own = parser.add_argument_group("for a URDF of your own")
    own.add_argument("--left-foot", metavar="LINK", help="link that carries the left sole")
    own.add_argument("--right-foot", metavar="LINK", help="link that carries the right sole")
    own.add_argument("--srdf", metavar="FILE", help="brings a posture to stand in")


def stated(options: argparse.Namespace) -> dict[str, Any]:
    """What the options state, as `wbc.load` takes it."""
    return {
        "left_foot": options.left_foot,
        "right_foot": options.right_foot,
        "srdf": options.srdf,
    }
