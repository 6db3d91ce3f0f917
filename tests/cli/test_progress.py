"""The progress that runs show."""

from __future__ import annotations

from wbc.cli.progress import ProgressLine


def test_progress_without_a_terminal_goes_on_after_a_reset(capsys):
    with ProgressLine(period=2.0) as line:
        for time in (0.0, 1.0, 2.0, 30.0, 0.0, 1.0, 2.5):
            line.show(f"at {time:g}", time)
    assert capsys.readouterr().err.split("\n")[:-1] == ["at 0", "at 2", "at 30", "at 0", "at 2.5"]
