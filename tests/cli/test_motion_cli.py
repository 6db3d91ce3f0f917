"""`wbc motion` on the command line."""

from __future__ import annotations

import json

import pytest

from wbc.cli import main
from wbc.motions import MOTIONS


def test_list_names_every_motion_and_fits_a_terminal(capsys):
    assert main(["motion", "--list"]) == 0
    said = capsys.readouterr().out
    for motion in MOTIONS:
        assert f"\n{motion.name} " in said
        assert motion.summary in said
    assert max(map(len, said.splitlines())) <= 100


@pytest.mark.parametrize("motion", MOTIONS, ids=lambda motion: motion.name)
def test_the_help_of_each_motion_lists_its_options(motion, capsys):
    assert main(["motion", motion.name, "--help"]) == 0
    said = capsys.readouterr().out
    for parameter in motion.parameters():
        assert f"--{parameter.name.replace('_', '-')}" in said
    assert "--robot" in said
    assert "--json" in said


def test_a_motion_is_played_and_reported(tmp_path, capsys):
    path = tmp_path / "bow.json"
    arguments = ["--robot", "simple_humanoid", "--angle", "15", "--hold", "0.1", "--seconds", "0.6"]
    assert main(["motion", "bow", *arguments, "--no-view", "--json", str(path)]) == 0
    said = capsys.readouterr().out
    assert "survived" in said
    assert "CoM tracking error" in said
    report = json.loads(path.read_text("utf-8"))
    assert report["survived"] is True
    assert report["com_error_rms_mm"] < 10.0
    assert report["foot_slip_mm"] < 5.0
    assert report["duration_s"] < 6.0


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["squat", "--robot", "g1", "--depth", "40"], "'left_ankle_pitch_joint'"),
        (["sway", "--size", "nan"], "not a finite number"),
        (["sway", "--shape", "square"], "invalid choice: 'square'"),
        (["reach", "--left", "1", "2"], "expected 3 arguments"),
        (["squad"], "invalid choice: 'squad'"),
        (["keyframes"], "--file"),
        (["keyframes", "--file", "none.csv"], "cannot read none.csv"),
        (["wave", "--robot", "no_such_robot"], "no_such_robot"),
    ],
)
def test_bad_input_is_reported_in_one_line(arguments, why, capsys):
    assert main(["motion", *arguments, "--no-view"]) == 2
    said = capsys.readouterr().err.strip()
    assert why in said
    assert said.count("\n") == 0
