"""The comparison with other libraries: everything of it that needs none of them."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import wbc

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))

from peers import compare, environments, report  # noqa: E402
from peers.agreement import active_rows, agreement  # noqa: E402
from peers.case import BOTH, Case  # noqa: E402
from peers.figures import figures, ratio  # noqa: E402
from peers.libraries import LIBRARIES  # noqa: E402
from peers.recording import (  # noqa: E402
    CASES,
    Sway,
    make_case,
    make_problem,
    record_sway,
    record_walk,
)
from peers.robot_file import urdf_text  # noqa: E402

OURS = [library for library in LIBRARIES if library.environment is None]


@pytest.fixture(scope="module")
def case():
    robot = wbc.load("simple_humanoid")
    problem = make_problem(robot, torque_scale=0.5, friction=0.2)
    ticks = record_sway(robot, problem, Sway(rest=0.02), 12)
    return make_case("sway", "a sway", problem, ticks)


@pytest.fixture(scope="module")
def found(case, tmp_path_factory):
    """A comparison of our two configurations with each other."""
    folder = tmp_path_factory.mktemp("peers")
    case.save(folder / case.name)
    comparison = compare.Comparison([case], list(OURS), {"nobody": "not made"})
    compare.run(comparison, {}, folder, rounds=2, passes=3)
    return comparison


@pytest.mark.parametrize("name", ["talos", "g1", "simple_humanoid"])
def test_a_robot_written_as_a_urdf_is_the_same_robot(name):
    robot = wbc.load(name)
    frames = {"sole": robot.soles[0].frame_id, "trunk": robot.frame_id(robot.torso)}
    text = urdf_text(robot.model, frames)
    again = pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    again.armature = robot.model.armature
    assert list(again.names) == list(robot.model.names)
    assert again.effortLimit == pytest.approx(robot.model.effortLimit)
    rng = np.random.default_rng(0)
    v = rng.normal(size=robot.nv)
    q = pin.integrate(robot.model, robot.q_nominal, rng.normal(size=robot.nv))
    data, data_again = robot.model.createData(), again.createData()
    M, M_again = pin.crba(robot.model, data, q), pin.crba(again, data_again, q)
    assert np.abs(M_again - M).max() < 1e-12
    h = pin.nonLinearEffects(robot.model, data, q, v)
    h_again = pin.nonLinearEffects(again, data_again, q, v)
    assert np.abs(h_again - h).max() < 1e-9
    pin.framesForwardKinematics(robot.model, data, q)
    pin.framesForwardKinematics(again, data_again, q)
    for frame, index in frames.items():
        placement = data_again.oMf[again.getFrameId(frame)]
        assert np.abs(placement.homogeneous - data.oMf[index].homogeneous).max() < 1e-12


def test_a_case_is_read_back_unchanged_from_its_files(case, tmp_path):
    case.save(tmp_path / "case")
    again = Case.load(tmp_path / "case")
    for name, value in vars(case.ticks).items():
        assert np.array_equal(getattr(again.ticks, name), value), name
    for name, value in vars(case.limits).items():
        assert np.array_equal(getattr(again.limits, name), value), name
    assert np.array_equal(again.mass_matrix, case.mass_matrix)
    same = ("name", "title", "robot", "urdf", "joints", "friction", "half_length", "gains")
    assert [getattr(again, k) for k in same] == [getattr(case, k) for k in same]


def test_a_peer_with_another_robot_is_refused(case):
    case.check_model(case.mass_matrix, case.bias_forces, list(case.joints))
    with pytest.raises(ValueError, match="differ by"):
        case.check_model(1.001 * case.mass_matrix, case.bias_forces, list(case.joints))
    with pytest.raises(ValueError, match="joints"):
        case.check_model(case.mass_matrix, case.bias_forces, list(case.joints)[::-1])


def test_figures_are_over_all_samples_and_over_each_ticks_median():
    times = np.full((5, 100), 100_000)
    times[:, 7] = 400_000  # a hard tick
    times[2, :50] = 900_000  # something else ran
    one = figures(times)
    assert (one.p50, one.max, one.p99) == (100.0, 900.0, 900.0)
    assert 100.0 < one.p99_of_ticks < 400.0
    assert figures(np.delete(times, 7, axis=1)).p99_of_ticks == 100.0


def test_the_ratio_is_ours_over_theirs_round_by_round():
    def times(scale):
        return np.full((2, 10), scale)

    found = ratio([times(10), times(30), times(20)], [times(40), times(40), times(40)])
    assert found.rounds == (0.25, 0.75, 0.5)
    assert found.p50 == found.median_of_rounds == 0.5


def test_sway_case_reaches_the_torque_limits_and_keeps_them(case, found):
    solutions = found.columns[case.name, "wbc"].solutions
    assert solutions["ok"].all()
    assert (np.abs(solutions["tau"]) <= case.limits.torque * (1.0 + 1e-9)).all()
    assert (case.ticks.stance == BOTH).all()
    assert active_rows(case, solutions).max() >= 1


def test_a_recorded_walk_has_the_reference_of_the_foot_in_the_air():
    pytest.importorskip("mujoco")
    ticks = record_walk(wbc.load("simple_humanoid"), 0.3, 2.5)
    flying = ticks.stance != BOTH
    assert flying.any()
    height = ticks.swing[flying, 2, 3]
    assert height.max() > height.min() + 0.04
    # The recorded velocity is the rate of the recorded position.
    last = np.flatnonzero(flying[1:] & flying[:-1])
    rate = np.diff(ticks.swing[:, :3, 3], axis=0)[last] / 0.002
    mean = 0.5 * (ticks.swing_velocity[1:, :3] + ticks.swing_velocity[:-1, :3])[last]
    same_foot = np.abs(rate).max(axis=1) < 5.0
    np.testing.assert_allclose(rate[same_foot], mean[same_foot], atol=0.05)


def test_active_rows_count_joints_at_their_torque_limit(case, found):
    solutions = dict(found.columns[case.name, "wbc"].solutions)
    count = active_rows(case, solutions)
    tau = 0.5 * np.clip(solutions["tau"], -case.limits.torque, case.limits.torque)
    none = active_rows(case, solutions | {"tau": tau})
    tau[:, :3] = case.limits.torque[:3]
    assert (active_rows(case, solutions | {"tau": tau}) == none + 3).all()
    assert (count >= none).all()


def test_agreement_measures_the_distance_between_solutions(case, found):
    ours = found.columns[case.name, "wbc"].solutions
    same = agreement(case, ours, ours)
    assert same.acceleration.max == same.com.max == same.torque.max == same.wrench.max == 0.0
    theirs = {name: values.copy() for name, values in ours.items()}
    theirs["tau"][3, 1] += 2.0
    theirs["acceleration"][:, 0] += 0.5
    theirs["ok"][0] = False
    theirs["tau"][0] = np.nan
    near = agreement(case, ours, theirs)
    assert near.unsolved == 1
    assert (near.torque.median, near.torque.max) == (0.0, pytest.approx(2.0))
    assert near.acceleration.median == pytest.approx(0.5)
    # A base that accelerates as a whole takes the centre of mass along.
    assert near.com.median == pytest.approx(0.5, rel=1e-4)


def test_both_configurations_of_the_controller_are_measured_in_turn(case, found, capsys):
    for library in OURS:
        column = found.columns[case.name, library.key]
        assert not column.failed
        assert [times.shape for times in column.cpu] == [(3, len(case.ticks))] * 2
        assert all((times > 0).all() for times in column.cpu + column.wall)
    report.show(found)
    said = capsys.readouterr().out
    assert "a sway: 12 ticks; active limits" in said
    assert "wbc, placo's problem" in said
    assert "missing: not made" in said
    options = compare.parser().parse_args([])
    plain = json.loads(json.dumps(compare.as_json(found, options)))
    assert plain["cases"]["sway"]["libraries"]["wbc"]["cpu_us"]["p50"] > 0.0
    assert len(plain["cases"]["sway"]["libraries"]["wbc"]["rounds_cpu_us"]) == 2


def test_the_plot_shows_every_case(found, tmp_path):
    pytest.importorskip("matplotlib")
    from peers.plot import draw

    draw(found, tmp_path / "peers.png")
    assert (tmp_path / "peers.png").read_bytes().startswith(b"\x89PNG")


def test_a_library_that_raises_is_reported_and_the_others_run(case, tmp_path, capsys):
    case.save(tmp_path / case.name)
    broken = replace(OURS[0], key="broken", label="broken", adapter="nowhere:Nothing")
    comparison = compare.Comparison([case], [broken, OURS[0]], {})
    compare.run(comparison, {}, tmp_path, rounds=1, passes=1)
    assert "nowhere" in comparison.columns[case.name, "broken"].failed
    assert "broken failed on sway" in capsys.readouterr().out
    assert comparison.figures(case.name, "broken") is None
    assert comparison.figures(case.name, "wbc") is not None


def test_an_environment_is_created_once_until_its_requirements_change(
    tmp_path, monkeypatch, capsys
):
    commands = []

    def run(command, **_):
        commands.append(command)
        if "venv" in command:
            python = Path(command[-1]) / "bin" / "python"
            python.parent.mkdir(parents=True)
            python.touch()
        failed = "pip" in command and "nowhere" in pinned.read_text()
        said = "ERROR: No matching distribution found for nowhere" if failed else ""
        return subprocess.CompletedProcess(command, int(failed), "", said)

    monkeypatch.setattr(environments, "LISTS", tmp_path)
    monkeypatch.setattr(environments.subprocess, "run", run)
    pinned = tmp_path / "requirements-some.txt"
    pinned.write_text("something==1.0\n")
    python = environments.prepare("some", tmp_path / "envs")
    assert "creating" in capsys.readouterr().out
    assert len(commands) == 2
    assert environments.prepare("some", tmp_path / "envs") == python
    assert "using environment" in capsys.readouterr().out
    assert len(commands) == 2
    pinned.write_text("nowhere==1.0\n")
    for _ in range(2):  # what failed half-way does not count as made
        with pytest.raises(environments.EnvironmentFailedError, match="No matching distribution"):
            environments.prepare("some", tmp_path / "envs")


def test_a_peer_without_environment_is_skipped_and_the_others_run(monkeypatch, tmp_path):
    def prepare(name, folder):
        if name == "tsid":
            raise environments.EnvironmentFailedError("tsid: no wheels today")
        return folder / name

    monkeypatch.setattr(environments, "prepare", prepare)
    keys = [library.key for library in LIBRARIES]
    libraries, pythons, missing = compare.available(keys, tmp_path)
    assert missing == {"TSID, eiquadprog-fast": "tsid: no wheels today"}
    assert [one.key for one in libraries] == [key for key in keys if key != "tsid"]
    assert pythons == {"placo": tmp_path / "placo", "pink": tmp_path / "pink"}


@pytest.mark.parametrize("name", ["tsid", "placo", "pink"])
def test_every_requirement_of_a_peer_is_pinned(name):
    lines = (environments.LISTS / f"requirements-{name}.txt").read_text().splitlines()
    packages = [line for line in lines if not line.startswith("#")]
    assert packages
    assert all(len(line.split("==")) == 2 for line in packages)


def test_tick_benchmark_with_peers_runs_the_comparison():
    command = [sys.executable, str(BENCHMARKS / "tick.py"), "--peers", "--help"]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert "--rounds" in said
    assert all(name in said for name in CASES)
