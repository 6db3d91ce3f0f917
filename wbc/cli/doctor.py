"""`wbc doctor`: what is wrong with a robot description, what follows, and the cure."""

from __future__ import annotations

import argparse
from collections import Counter
from typing import Any

from wbc.cli.parser import ERRORS
from wbc.cli.robot_options import add_robot_options, stated
from wbc.cli.text import paragraph
from wbc.robot import Finding
from wbc.robot.doctor import check_file
from wbc.robot.finding import SEVERITIES

_WIDTH = 100
_INDENT = 10


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "doctor",
        help="find what is wrong with a robot description",
        description="Examines a robot description: each defect, what follows from it, and the "
        "cure. Exit code 0: the robot can be controlled; 1: it has errors.",
    )
    parser.add_argument(
        "file", metavar="FILE.urdf", help="a URDF, a robot data file or a robot's name"
    )
    add_robot_options(parser)
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Examine; returns the exit code."""
    findings = check_file(options.file, **stated(options))
    for finding in findings:
        print(_entry(finding))
    counts = Counter(finding.severity for finding in findings)
    summary = ", ".join(
        f"{counts[s]} {s}{'s' if counts[s] > 1 else ''}" for s in SEVERITIES if counts[s]
    )
    print(f"{options.file}: {summary or 'sound, nothing found'}")
    return ERRORS if counts["error"] else 0


def _entry(finding: Finding) -> str:
    lines = [f"{finding.severity:<{_INDENT}}{finding.subject}"]
    lines += [
        paragraph(text, _INDENT, _WIDTH)
        for text in (finding.what, f"→ {finding.consequence}", f"cure: {finding.cure}")
    ]
    return "\n".join(lines) + "\n"
