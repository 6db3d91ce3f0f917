"""`wbc doctor`: the defects of a robot description, their consequences and cures."""

from __future__ import annotations

from collections import Counter

from wbc.cli.exit_code import ExitCode
from wbc.cli.formatting import paragraph
from wbc.cli.model_options import ModelOptions
from wbc.gait import check_walking
from wbc.robot.doctor import check_file
from wbc.robot.finding import SEVERITIES

_INDENT = 10


def doctor(robot: str, model: ModelOptions) -> ExitCode:
    """Check a robot description and print each defect with its consequence and its cure.

    Exit code 0: the robot can be controlled; 1: the description has errors.

    Args:
        robot: name of a robot, or path of a URDF or robot data file.
        model: properties of the robot.
    """
    findings = check_file(robot, **model.load_arguments())
    if not any(finding.severity == "error" for finding in findings):
        findings += check_walking(model.load(robot))
        findings.sort(key=lambda finding: SEVERITIES.index(finding.severity))
    for finding in findings:
        print(f"{finding.severity:<{_INDENT}}{finding.subject}")
        for text in (finding.what, f"→ {finding.consequence}", f"cure: {finding.cure}"):
            print(paragraph(text, _INDENT))
        print()
    counts = Counter(finding.severity for finding in findings)
    summary = ", ".join(
        f"{counts[s]} {s}{'s' if counts[s] > 1 else ''}" for s in SEVERITIES if counts[s]
    )
    print(f"{robot}: {summary or 'no defects found'}")
    return ExitCode.FAILED if counts["error"] else ExitCode.SUCCESS
