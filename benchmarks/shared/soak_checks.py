"""Checks what a session of the soak has left: log, report, recording, answers, processes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from shared.soak_page import Page
from wbc.log import Log, LoggedRun

KILLED = ("SIGKILL", "log writer killed", "disk full")  # the log ends early
_LAST = 1.0  # s of a log that may be missing when its writer is killed
_EXIT_CODES = {"SIGKILL": -9, "SIGINT": 130}


@dataclass
class Verdict:
    """What became of a session.

    Attributes:
        ending: How it ended.
        ticks: Ticks of its runs.
        sent: Commands of its pages.
        accepted: Those of them that were acknowledged as accepted.
        log: What the log has, in words.
        lost: What was lost, a line each.
    """

    ending: str
    ticks: int
    sent: int = 0
    accepted: int = 0
    log: str = ""
    lost: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        """Return a line."""
        lost = "; ".join(self.lost) if self.lost else "nothing lost"
        return f"{self.ending}: {self.ticks} ticks, {self.sent} commands; {self.log}; {lost}"


def check_session(
    folder: Path,
    ending: str,
    code: int,
    ticks: np.ndarray,
    pages: Sequence[Page],
    left: Sequence[str],
    html: bool,
) -> Verdict:
    """Return what was lost of a session that has ended.

    Args:
        folder: Its folder.
        ending: How it ended.
        code: Its exit code.
        ticks: Its ticks, see `shared.soak_session.TICK`.
        pages: All its pages.
        left: Names of processes that still run.
        html: Whether it was to write a recording.
    """
    verdict = Verdict(ending, len(ticks))
    lost = verdict.lost
    expected = _EXIT_CODES.get(ending, 143)
    if code != expected:
        lost.append(f"exit code {code} instead of {expected}")
    lost += [f"process left: {name}" for name in left]
    for page in pages:
        verdict.sent += page.sent
        if page.answered < page.sent:
            lost.append(f"{page.sent - page.answered} of {page.sent} commands of a page unanswered")
    _check_log(folder / "log.mcap", ticks, pages, verdict)
    if ending != "SIGKILL":
        _check_files(folder, html, lost)
    return verdict


def _check_log(path: Path, ticks: np.ndarray, pages: Sequence[Page], verdict: Verdict) -> None:
    run = LoggedRun(Log(path, topics=("/controller_state", "/events")))
    missing = len(ticks) - len(run)
    text = f"log of {len(run)} ticks, {len(run.events)} events"
    if run.log.gaps:
        verdict.lost.append(f"{len(run.log.gaps)} gaps in the log")
    early = verdict.ending in KILLED
    if not early and missing:
        verdict.lost.append(f"{missing} ticks are not in the log")
    if early:
        ended = ticks["ended"][len(run) - 1 :]
        text += f", which ends {ended[-1] - ended[0]:.2f} s before the last tick"
    if verdict.ending == "SIGKILL" and missing * 0.002 > _LAST:
        verdict.lost.append(f"the last {missing * 0.002:.2f} s are not in the log")
    if not run.log.complete and verdict.ending != "SIGKILL":
        verdict.lost.append("the log has no end")
    steps = np.diff(run.stamps)
    if (steps <= 0).any():
        verdict.lost.append("times of the log go back")
    known = {(e.number, e.outcome) for e in run.events if e.kind == "command"}
    for page in pages:
        accepted = {(n, o) for n, outcomes in page.outcomes.items() for o in outcomes}
        accepted = {one for one in accepted if one[1] in ("accepted", "done", "aborted")}
        verdict.accepted += sum(outcome == "accepted" for _, outcome in accepted)
        if not early and (unknown := accepted - known):
            verdict.lost.append(f"{len(unknown)} acknowledgements are not in the log")
    verdict.log = text


def _check_files(folder: Path, html: bool, lost: list[str]) -> None:
    try:
        json.loads((folder / "report.json").read_text())
    except (OSError, ValueError):
        lost.append("no report")
    if html:
        recording = folder / "recording.html"
        whole = recording.exists() and "</html>" in recording.read_text("utf-8")[-200:]
        if not whole:
            lost.append("no recording")
    if files := sorted(path.name for path in (folder / "tmp").iterdir()):
        lost.append(f"files left: {', '.join(files)}")
