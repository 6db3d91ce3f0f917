"""Every example runs as a user runs it, and says what it promises."""

import os
import re
import runpy
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
LONG = ("20_trials", "21_stairs")
# In a process of its own, as a user runs it: the walk, and what other processes import. The others
# spare the seconds that loading takes.
ALONE = ("03_walk", "20_trials")
SAYS = {
    "01_kinematics": "free fall, CoM at",
    "02_stand": "left_sole carries",
    "03_walk": "survived",
    "04_view": "open ",
    "05_own_controller": "survived",
    "06_own_plant": "survived",
    "07_infeasible": "pulled down: infeasible",
    "26_self_collision": "with torques: ok, never less than ",
    "08_footsteps": "survived",
    "09_own_robot": "survived",
    "10_motions": "stands as before: True",
    "11_log": "the runs diverge at 0.000 s",
    "17_commands": "survived",
    "18_own_quantity": "largest power: joint_power: ",
    "12_live": "survived",
    "13_own_task": "after 2.0 s the hands are 0.300 m apart",
    "14_own_limit": "target 150 mm below the table; the hand stayed 0.0 mm above it",
    "23_servos": "torque for the legs: survived True",
    "15_own_contact": "with 22 rows: ok",
    "16_own_solver": "own solver: ok",
    "19_own_planner": "survived",
    "20_trials": "upright against walker: ",
    "21_stairs": "survived",
    "22_inverse_kinematics": "held back by joint position limit",
    "27_quadruped": "survived 5.0 s",
    "24_priorities": "three levels: CoM moved 0.",
    "25_explain": "these constraints conflict — stay [x] off by 0.5 m/s²; go [x] off by 0.5 m/s²",
}


def run_alone(script: Path, folder: Path) -> str:
    done = subprocess.run(
        [sys.executable, str(script)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT), "TMPDIR": str(folder)},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=180,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize(
    "script",
    [
        pytest.param(path, id=path.stem, marks=[pytest.mark.slow] if path.stem in LONG else [])
        for path in EXAMPLES
    ],
)
def test_example_runs(script, tmp_path, monkeypatch, capsys):
    if script.stem in ALONE:
        said = run_alone(script, tmp_path)
    else:
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
        runpy.run_path(str(script), run_name="__main__")
        said = capsys.readouterr().out
    assert SAYS[script.stem] in said
    assert "FELL" not in said


@pytest.mark.parametrize("script", EXAMPLES, ids=lambda path: path.stem)
def test_example_is_short_and_explains_itself(script):
    text = script.read_text("utf-8")
    assert text.startswith('"""'), "an example begins with its one idea"
    assert len(text.splitlines()) <= 65
    assert not re.search(r"\bUSE_\w+|\binput\(", text)


def test_examples_are_numbered_without_gaps():
    assert [path.name[:3] for path in EXAMPLES] == [f"{k:02}_" for k in range(1, len(EXAMPLES) + 1)]
