"""The progress that runs show."""

from __future__ import annotations

import math

from wbc.cli.progress import ProgressBar, ProgressLine
from wbc.runtime.statistics import Progress


def test_progress_without_a_terminal_goes_on_after_a_reset(capsys):
    with ProgressLine(period=2.0) as line:
        for time in (0.0, 1.0, 2.0, 30.0, 0.0, 1.0, 2.5):
            line.show(f"at {time:g}", time)
    assert capsys.readouterr().err.split("\n")[:-1] == ["at 0", "at 2", "at 30", "at 0", "at 2.5"]


class Clock:
    def __init__(self):
        self.now = 0.0

    def __call__(self):
        return self.now


def test_a_bar_shows_the_time_left_of_what_takes_long(capsys):
    clock = Clock()
    with ProgressBar("reading a log", clock) as bar:
        bar.show(0.2)
        assert capsys.readouterr().err == "", "what is quick needs no bar"
        clock.now = 25.0
        bar.show(0.25)
    told = capsys.readouterr().err
    assert "reading a log, 1 min 15 s left" in told
    assert told.count("█") == round(0.25 * 30)


def test_a_run_shows_the_time_left_by_its_pace(capsys):
    clock = Clock()
    with ProgressLine(1.0, clock) as line:
        for time in (1.0, 3.0):
            clock.now = 10.0 * time
            line.show_run(Progress(time, 7.0, 0.2, math.nan, 100.0))
    first, second = capsys.readouterr().err.splitlines()
    assert "left" not in first
    assert second.endswith("40 s left")
