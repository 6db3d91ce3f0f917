"""`wbc doctor`: the defects of a robot description, their consequences and cures."""

from __future__ import annotations

import argparse
from collections import Counter
from typing import Any

from wbc.cli.exit_codes import FAILED, SUCCESS
from wbc.cli.formatting import output_width, paragraph
from wbc.cli.robot_options import add_model_options, load_arguments
from wbc.robot import Finding
from wbc.robot.doctor import check_file
from wbc.robot.finding import SEVERITIES

_INDENT = 10


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "doctor",
        help="check a robot description",
        description="Checks a robot description and prints each defect with its consequence and "
        "its cure. Exit code 0: the robot can be controlled; 1: the description has errors.",
    )
    parser.add_argument(
        "file", metavar="ROBOT", help="path of a URDF or robot data file, or name of a robot"
    )
    add_model_options(parser)
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Check; return the exit code."""
    findings = check_file(options.file, **load_arguments(options))
    for finding in findings:
        print(_entry(finding))
    counts = Counter(finding.severity for finding in findings)
    summary = ", ".join(
        f"{counts[s]} {s}{'s' if counts[s] > 1 else ''}" for s in SEVERITIES if counts[s]
    )
    print(f"{options.file}: {summary or 'no defects found'}")
    return FAILED if counts["error"] else SUCCESS


def _entry(finding: Finding) -> str:
    lines = [f"{finding.severity:<{_INDENT}}{finding.subject}"]
    lines += [
        paragraph(text, _INDENT, output_width())
        for text in (finding.what, f"→ {finding.consequence}", f"cure: {finding.cure}")
    ]
    return "\n".join(lines) + "\n"
