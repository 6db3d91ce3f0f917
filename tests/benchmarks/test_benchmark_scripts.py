"""The benchmarks of correctness, scaling and solvers keep running and keep their keys."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from random_cases import hands, synthetic

import wbc
from wbc.command import Status

FOLDER = Path(__file__).parents[2] / "benchmarks"


def run(script: str, *flags: str) -> str:
    command = [sys.executable, str(FOLDER / script), *flags]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize(("joints", "seed"), [(15, None), (20, None), (57, 3), (100, None)])
def test_a_synthetic_humanoid_has_the_joints_asked_for_and_stands(joints, seed):
    robot = synthetic.load(joints, seed)
    assert robot.na == joints
    assert [f for f in robot.check() if f.severity.value == "error"] == []
    assert 45.0 < robot.mass < 85.0
    assert set(hands(robot)) <= {f.name for f in robot.model.frames}
    control = wbc.WholeBodyController(robot)
    control.add(wbc.ComTask())
    control.add(wbc.PostureTask(robot))
    control.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in robot.soles])
    command = control.step(robot.standing())
    assert command.status is Status.OK
    load = sum(command.wrenches[sole.name][2] for sole in robot.soles)
    np.testing.assert_allclose(load, robot.weight, rtol=1e-2)


def test_too_few_joints_for_a_humanoid_are_refused():
    with pytest.raises(ValueError, match="14 joints are too few"):
        synthetic.urdf(14)


@pytest.mark.slow
def test_the_scaling_benchmark_prints_exponents_and_writes_json(tmp_path):
    out = tmp_path / "scaling.json"
    assert "exponent" in run("scaling.py", "--ticks", "2", "--repeat", "1", "--json", str(out))
    found = json.loads(out.read_text())
    assert [p["size"] for p in found["contacts"]["points"]] == [0, 1, 2, 3, 4]
    assert all(p["p50_us"] > 0.0 for what in found.values() for p in what["points"])


def test_the_terrain_benchmark_tells_who_gets_across(tmp_path):
    pytest.importorskip("mujoco")
    out = tmp_path / "terrain.json"
    flags = ["--robot", "simple_humanoid", "--terrain", "stones", "--seeds", "1", "--jobs", "1"]
    assert "| simple_humanoid | 1/1 |" in run("terrain.py", *flags, "--json", str(out))
    (found,) = json.loads(out.read_text())
    assert found["passed"]
    assert found["way"] > 1.5


def test_the_punches_benchmark_counts_every_punch_by_part_turn_and_jump():
    pytest.importorskip("mujoco")
    printed = run("punches.py", "--tours", "1", "--condition", "strength").splitlines()
    assert printed[0] == "g1: punches at full force that are survived"
    assert printed[1].startswith("steps catch a DCM that is up to 0.3")
    assert 0 < int(re.match(r"(\d+) % of 1000 tours", printed[2])[1]) < 100
    rows = [row for row in printed if re.search(r"\d+/\d+", row)]
    (total,), *by_kind = (
        [tuple(map(int, cell.split("/"))) for cell in re.findall(r"\d+/\d+", row)] for row in rows
    )
    survived, punches = total
    assert 1 <= punches <= 3
    assert punches - survived <= 1
    assert len(by_kind) == 3
    for counts in by_kind:
        assert tuple(map(sum, zip(*counts, strict=True))) == total


@pytest.mark.slow
def test_the_solver_benchmark_says_what_the_default_is_and_why(tmp_path):
    out = tmp_path / "solvers.json"
    flags = ["--ticks", "3", "--passes", "1", "--solver", "default", "--solver", "daqp"]
    assert "The default" in run("solvers.py", *flags, "--json", str(out))
    found = json.loads(out.read_text())["found"]
    assert len(found) == 8
    assert all(f["failed"] == 0 and f["x_off"] < 1e-6 for f in found)


@pytest.mark.slow
def test_the_correctness_benchmark_counts_every_problem(tmp_path):
    out = tmp_path / "correctness.json"
    kind = "smooth sequence"
    flags = ["--problems", "12", "--kind", kind, "--solver", "default", "--json", str(out)]
    assert "0 faults" in run("correctness.py", *flags)
    tally = json.loads(out.read_text())["default"][kind]
    assert tally["ticks"] == 12 == tally["solvable"] + tally["ill_conditioned"]


@pytest.mark.slow
def test_the_observers_benchmark_measures_ticks_calls_and_rates(tmp_path):
    for package in ("mujoco", "cyclonedds", "mcap"):
        pytest.importorskip(package)
    out = tmp_path / "observers.json"
    flags = ["--robot", "simple_humanoid", "--rounds", "1", "--seconds", "1"]
    flags += ["--only", "viewer, log, ROS 2", "--undisturbed", "0.6"]
    flags += ["--messages", "0", "--repeats", "0", "--json", str(out)]
    assert "viewer, log, ROS 2" in run("observers.py", *flags)
    told = json.loads(out.read_text())
    nothing, everyone = told["cells"].values()
    assert nothing["ticks"] == everyone["ticks"] > 100
    assert all(nothing[f"{kind} p99 ratio"] == 1.0 for kind in ("command", "whole", "CPU"))
    undisturbed = told["undisturbed"]
    assert len(undisturbed["calls"]) == 5
    assert all(call["per tick"] > 0.0 for call in undisturbed["calls"].values())
    for rate in ("viewer: frames at a page", "ROS 2: /tf at a node", "log: MB per minute"):
        assert any(name.startswith(rate) for name in undisturbed["figures"]), rate


@pytest.mark.slow
def test_the_whole_body_ik_benchmark_reaches_without_penetration(tmp_path):
    out = tmp_path / "ik.json"
    run("whole_body_ik.py", "collision", "--robot", "g1", "--samples", "3", "--json", str(out))
    (found,) = json.loads(out.read_text())
    assert found["solved"] == 100.0
    assert found["least"] > -1.0
    run("whole_body_ik.py", "balance", "--robot", "g1", "--samples", "5", "--json", str(out))
    assert json.loads(out.read_text())[0]["solved"] == 100.0
