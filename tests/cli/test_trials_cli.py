"""`wbc trials`: the verbs, their output and exit codes."""

from __future__ import annotations

import re
import signal
import time
from dataclasses import replace

import pytest
from clitools import start
from policytools import write_standing_policy
from trialtools import made_up

import wbc
from wbc.cli.entry import run
from wbc.trials import ControllerSpec, Results, read_results


@pytest.fixture
def files(tmp_path):
    """A weak and a strong controller, and both in one file."""
    pytest.importorskip("pyarrow")
    weak, strong = made_up(0.3, spread=0.0), made_up(0.7, spread=0.0, draw=1)
    weak.write(tmp_path / "weak.parquet")
    strong.write(tmp_path / "strong.parquet")
    return tmp_path


def test_show_prints_the_largest_size_survived_by_robot_and_direction(files, capsys):
    assert run(["trials", "show", str(files / "weak.parquet"), "--rates"]) == 0
    printed = capsys.readouterr().out
    head, *rows = (line.split() for line in printed.splitlines() if "forward" in line)
    assert head == ["robot", "motion", "forward", "left", "back", "right"]
    assert rows[0][:7] == ["g1", "standing", "forward", "0.2", "12/12", "100", "%"]
    assert "g1     0.3 m/s       0.2   0.2   0.2    0.2" in printed


def test_show_lists_the_falls_with_the_smallest_pushes(files, capsys):
    assert run(["trials", "show", str(files / "strong.parquet"), "--falls", "2"]) == 0
    *_, first, second, last = capsys.readouterr().out.splitlines()
    assert "made up" in first
    assert " 0.8 " in second
    assert last == "96 falls in all"


def test_show_says_how_many_falls_a_controller_announced_and_how_long_before(tmp_path, capsys):
    pytest.importorskip("pyarrow")
    made = made_up(0.7)
    rows, left = [], 2
    for row in made.rows:
        if row.survived or not left:
            rows.append(replace(row, survived=True, fell_at_s=None))
        else:
            left -= 1
            rows.append(replace(row, fell_at_s=1.0, falling_at_s=0.75 if left else None))
    Results(tuple(rows), made.grid, made.provenance).write(tmp_path / "falls.parquet")
    assert run(["trials", "show", str(tmp_path / "falls.parquet")]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert "walker: announced 1 of 2 falls, 0.25 s before at the median" in printed


def test_a_trial_that_does_not_exist_cannot_be_replayed(files, capsys):
    assert run(["trials", "replay", str(files / "weak.parquet"), "nothing"]) == 2
    assert "no trial of 'trials' have a key" in capsys.readouterr().err
    assert run(["trials", "replay", str(files / "weak.parquet"), ""]) == 2


def test_compare_gives_a_verdict_and_fails_if_the_second_is_worse(files, capsys):
    weak, strong = str(files / "weak.parquet"), str(files / "strong.parquet")
    assert run(["trials", "compare", weak, strong]) == 0
    assert "On the whole: better." in capsys.readouterr().out
    assert run(["trials", "compare", strong, weak]) == 1
    assert "On the whole: worse." in capsys.readouterr().out
    assert run(["trials", "compare", weak, weak, "--controllers", "walker", "other"]) == 2
    assert "no results of 'other'" in capsys.readouterr().err


def test_plot_prints_the_paths_of_its_plots(files, capsys):
    assert run(["trials", "plot", str(files / "weak.parquet"), "--format", "svg"]) == 0
    paths = capsys.readouterr().out.split()
    assert paths == [str(files / f"weak_{name}.svg") for name in ("push_map", "survival")]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nothing.toml"], "cannot read nothing.toml"),
        (["run", "nothing.toml"], "cannot read nothing.toml"),
        (["show", "nothing.parquet"], "cannot read results"),
        (["--workers", "0", "grid.toml"], "1 or greater"),
    ],
)
def test_bad_input_is_told_in_one_line(arguments, words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run(["trials", *arguments]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1


def test_a_finished_grid_is_shown_and_not_run_again(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    results = made_up(0.5, controllers=(ControllerSpec(options={"recovery": False}),))
    results.write(tmp_path / "grid.parquet")
    from wbc.trials import write_grid

    write_grid(results.grid, tmp_path / "grid.toml")
    assert run(["trials", "grid.toml"]) == 0
    printed = capsys.readouterr()
    assert f"{len(results.rows)} of {len(results.rows)} results are in grid.parquet" in printed.err
    assert str(tmp_path / "grid.parquet") in printed.out


def test_a_policy_is_run_with_the_robots_of_a_grid_that_it_is_made_for(
    tmp_path, capsys, monkeypatch
):
    pytest.importorskip("mujoco")
    pytest.importorskip("onnxruntime")
    pytest.importorskip("yaml")
    monkeypatch.chdir(tmp_path)
    write_standing_policy(tmp_path, wbc.load("simple_humanoid"))
    grid = 'sizes = [0.05]\nphases = 1\nduration = 0.2\ndirections = ["left"]\n'
    robots = [f'[[robots]]\nrobot = "{name}"\n' for name in ("simple_humanoid", "icub")]
    (tmp_path / "both.toml").write_text(grid + "".join(robots))
    (tmp_path / "neither.toml").write_text(grid + robots[1])
    assert run(["trials", "neither.toml", "--policy", "."]) == 2
    assert "the policy commands 20 joints and icub has 29" in capsys.readouterr().err
    assert run(["trials", "both.toml", "--policy", ".", "--rates"]) == 0
    printed = capsys.readouterr()
    assert "without the policy: " in printed.err
    runs = read_results("both.parquet").runs
    assert {(row.robot, row.controller) for row in runs} == {
        ("simple_humanoid", "walker"),
        ("simple_humanoid", "policy"),
        ("icub", "walker"),
    }


def test_a_signal_ends_a_run_without_losing_what_was_finished(tmp_path):
    pytest.importorskip("mujoco")
    (tmp_path / "grid.toml").write_text(
        'sizes = [0.1, 0.2, 0.3]\nphases = 6\nduration = 1.0\n[[robots]]\nrobot = "simple_humanoid"'
    )
    process = start("trials", "grid.toml", "--workers", "1", cwd=tmp_path)
    partial = tmp_path / "grid.parquet.partial"
    deadline = time.monotonic() + 120.0
    while not (partial.exists() and partial.read_bytes().count(b"\n") > 2):
        assert time.monotonic() < deadline, "no trial was finished"
        time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    out, error = process.communicate(timeout=60)
    assert process.returncode == 130, error
    left = re.search(r"stopped: (\d+) of 73 are left; the same command goes on", error)
    assert int(left.group(1)) == 73 - (partial.read_bytes().count(b"\n") - 1)
    assert "Traceback" not in error
    assert out == ""
