"""Examines a robot description in a process of its own: `python -m wbc.live.description_check`.

The file comes from a page, and reading it may take long or fail in any way: neither the page's
server nor the loop is concerned.
"""

from __future__ import annotations

import asyncio
import json
import sys
from typing import TYPE_CHECKING, Any

from wbc.errors import WbcError

if TYPE_CHECKING:
    from pathlib import Path

_TIMEOUT = 60.0  # s


async def examined(path: Path) -> list[dict[str, str]]:
    """Return the findings about a robot description as JSON, the worst first.

    See `wbc.robot.Finding` for the keys; one of severity "error" prevents a session.
    """
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", __name__, str(path),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.DEVNULL,
    )  # fmt: skip
    try:
        output, _ = await asyncio.wait_for(process.communicate(), _TIMEOUT)
    except asyncio.TimeoutError:
        process.kill()
        await process.wait()
        return [_failure(path.name, f"it takes more than {_TIMEOUT:g} s to examine it")]
    try:
        findings: list[dict[str, str]] = json.loads(output)
    except ValueError:
        return [_failure(path.name, "it cannot be examined: its reader has ended")]
    return findings


def _failure(subject: str, what: str) -> dict[str, str]:
    return {
        "severity": "error",
        "subject": subject,
        "what": what,
        "consequence": "the robot cannot be loaded",
        "cure": "run wbc doctor on the file",
    }


def _examine(path: str) -> list[dict[str, Any]]:
    from wbc.gait import check_walking
    from wbc.robot import load
    from wbc.robot.doctor import check_file
    from wbc.robot.finding import SEVERITIES

    try:
        findings = check_file(path)
        if not any(finding.severity == "error" for finding in findings):
            findings = [*findings, *check_walking(load(path))]
    except WbcError as error:
        return [_failure(path.rpartition("/")[2], str(error))]
    return [
        {
            "severity": one.severity,
            "subject": one.subject,
            "what": one.what,
            "consequence": one.consequence,
            "cure": one.cure,
        }
        for one in sorted(findings, key=lambda one: SEVERITIES.index(one.severity))
    ]


if __name__ == "__main__":
    print(json.dumps(_examine(sys.argv[1])))
