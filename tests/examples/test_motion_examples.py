"""The motions' examples: short, numbered, and each does what it says."""

from __future__ import annotations

import ast
import runpy
from pathlib import Path

import pytest

import wbc
from wbc.cli import main
from wbc.cli.scripted_run import RunOptions
from wbc.motions import MOTIONS, Demo, Motion

FOLDER = Path(__file__).resolve().parents[2] / "examples" / "motions"
EXAMPLES = sorted(FOLDER.glob("*.py"))

#: What they say; those that are left out are played to their end by other tests and by
#: benchmarks/motions.py, and here for a moment only.
SAYS = {
    "02_squat": "21.0 % is the most",
    "04_reach": "out of reach by",
    "07_bow": "survived",
    "09_sine": "open loop: the base is only",
    "10_jump": "soles cleared",
    "11_keyframes": "robot_dance.csv:3:11: g1 has no joint 'torso_yaw'",
    "13_own_motion": "2 kicks",
}


@pytest.mark.parametrize("name", SAYS)
def test_example_prints_the_expected_result(name, capsys):
    runpy.run_path(str(FOLDER / f"{name}.py"), run_name="__main__")
    said = capsys.readouterr().out
    assert SAYS[name] in said
    assert "FELL" not in said


@pytest.mark.parametrize("name", [p.stem for p in EXAMPLES if p.stem not in SAYS])
def test_example_runs(name, capsys, monkeypatch):
    def briefly(controller, plant, duration, **options):
        return run(controller, plant, 0.6, **options)

    run = wbc.run
    monkeypatch.setattr(wbc, "run", briefly)
    monkeypatch.setattr("wbc.trials.motion_trial.run", briefly)
    runpy.run_path(str(FOLDER / f"{name}.py"), run_name="__main__")
    assert "survived 0.6 s" in capsys.readouterr().out


@pytest.mark.parametrize("script", EXAMPLES, ids=lambda path: path.stem)
def test_example_is_short_and_uses_what_there_is(script):
    text = script.read_text("utf-8")
    assert text.startswith('"""')
    assert len(text.splitlines()) <= 60
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and node.module == "wbc.motions":
            for alias in node.names:
                assert hasattr(wbc.motions, alias.name), alias.name


def test_every_motion_has_an_example():
    text = "".join(script.read_text("utf-8") for script in EXAMPLES)
    for motion in MOTIONS:
        assert f"{motion.__name__}(" in text


def test_examples_are_numbered_without_gaps():
    assert [path.name[:3] for path in EXAMPLES] == [f"{k:02}_" for k in range(1, len(EXAMPLES) + 1)]


def test_the_gallery_shows_every_motion_by_a_command_that_there_is(monkeypatch):
    played = []

    def play(motion: Motion, run: RunOptions, *, duration: float | None = None) -> None:
        played.append(type(motion))

    monkeypatch.setattr("wbc.cli.motion.play", play)
    docs = FOLDER.parents[1] / "docs"
    text = (docs / "motions.md").read_text("utf-8")
    for line in text.splitlines():
        if line.startswith("wbc motion "):
            assert main(line.split()[1:]) == 0, line
        if line.startswith("<img"):
            assert (docs / line.split('"')[1]).is_file()
    assert set(played) == {*MOTIONS} - {Demo}
    assert (docs / "motions.png").stat().st_size < 1.5e6
