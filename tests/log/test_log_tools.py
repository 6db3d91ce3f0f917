"""`wbc plot`, `wbc diff` and `wbc log`, and what they are made of."""

import os
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from logtools import StreamedLog, contact_plan, random_tick, robot, telemetry
from matplotlib.figure import Figure

import wbc
from wbc.cli import main
from wbc.command import Status
from wbc.log import FlightRecorder, LogError
from wbc.log.diff import compare
from wbc.log.logged_robot import logged_robot
from wbc.log.plots import plot
from wbc.log.plots.balance import (
    draw_coordinate,
    draw_dcm_error,
    draw_top_view,
    footprints,
    top_view_size,
)
from wbc.log.plots.forces import draw_friction, draw_normal_forces
from wbc.log.plots.joint_lines import largest_joints
from wbc.log.plots.joints import draw_power, draw_tracking, draw_velocities, tracking_error
from wbc.log.plots.style import spans
from wbc.log.plots.timing import draw_tick_time
from wbc.log.plots.torques import draw_torque_peaks, draw_torques
from wbc.log.run import LoggedRun
from wbc.runtime.event import RunEvent
from wbc.sim import Mujoco


def logged_walk(path, *, seconds=1.5, gains=None, seed=0, push=None):
    g1 = wbc.load("g1")
    walker = wbc.Walker(g1, gains=gains)
    walker.velocity = (0.2, 0.0, 0.0)
    plant = Mujoco(g1, dt=walker.dt, seed=seed)
    if push is not None:
        plant.schedule_push(*push)
    with FlightRecorder(path, g1) as log:
        report = wbc.run(walker, plant, seconds, observers=[log])
    return report


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("tools")


@pytest.fixture(scope="module")
def walk(folder):
    report = logged_walk(folder / "walk.mcap")
    return LoggedRun.read(folder / "walk.mcap"), report


@pytest.fixture
def axes():
    return Figure().subplots()


def line(axes, label):
    (found,) = [one for one in axes.get_lines() if one.get_label() == label]
    return found


def test_top_view_plot_shows_the_path_and_the_footsteps(walk, axes):
    run, report = walk
    draw_top_view(axes, run)
    np.testing.assert_array_equal(line(axes, "CoM").get_xydata(), run["com"][:, :2])
    np.testing.assert_array_equal(line(axes, "DCM").get_xydata(), run["dcm"][:, :2])
    prints = list(footprints(run))
    # Both soles where it stood, and one place for every touchdown.
    assert len(prints) == 2 + report.steps
    assert {side for side, _ in prints} == {"left", "right"}
    for side, corners in prints:
        length, width = run.robot_info.soles[side == "right"]
        edges = np.linalg.norm(np.diff(corners, axis=0), axis=1)
        np.testing.assert_allclose(edges, [2 * length, 2 * width, 2 * length], rtol=1e-9)
    # A foot that carries the robot has its centre of pressure inside.
    single = run["phase"] == 2
    cop = run["cop"][single, :2]
    left = np.array([c for side, c in prints if side == "left"])
    inside = ((cop[:, None] > left.min(axis=1)) & (cop[:, None] < left.max(axis=1))).all(axis=2)
    assert inside.any(axis=1).mean() > 0.95


def test_balance_plot_shows_reference_and_error(walk, axes):
    run, report = walk
    draw_coordinate(axes, run, 1)
    np.testing.assert_array_equal(line(axes, "DCM reference").get_xdata(), run.time)
    np.testing.assert_array_equal(line(axes, "ZMP, commanded").get_ydata(), run["zmp"][:, 1])
    axes = Figure().subplots()
    draw_dcm_error(axes, run)
    (text,) = axes.texts
    assert text.get_text() == f"rms {report.dcm_error_rms_mm:.1f} mm"


def test_torque_plots_show_the_peak_of_the_report(walk, axes):
    run, report = walk
    draw_torques(axes, run)
    highest = max(one.get_ydata().max() for one in axes.get_lines() if len(one.get_xdata()) > 2)
    assert highest == pytest.approx(100.0 * report.torque_peak_ratio)
    axes = Figure().subplots()
    draw_torque_peaks(axes, run)
    widths = [bar.get_width() for bar in axes.containers[0]]
    assert max(widths) == pytest.approx(100.0 * report.torque_peak_ratio)
    assert axes.get_yticklabels()[-1].get_text() in run.robot_info.joints


def test_force_plot_shows_the_weight_on_the_soles(walk, axes):
    run, _ = walk
    draw_normal_forces(axes, run)
    shown = [line(axes, f"{side}, measured").get_ydata() for side in ("left", "right")]
    standing = run.time < 0.5
    total = np.sum(shown, axis=0)[standing]
    assert np.median(total) == pytest.approx(run.robot_info.weight, rel=0.05)
    axes = Figure().subplots()
    draw_friction(axes, run)
    ratios = np.concatenate([one.get_ydata() for one in axes.get_lines()])
    assert np.nanmin(ratios) >= 0.0
    assert np.nanmax(ratios) < 2.0


def test_joint_plots_show_tracking_velocities_and_power(walk, axes):
    run, _ = walk
    error = tracking_error(run)
    assert np.isnan(error[0]).all()
    np.testing.assert_array_equal(error[5], run["joint_position"][5] - run["q_target"][4])
    assert np.nanpercentile(np.abs(error), 90) < 0.01, "the plant follows its targets"
    draw_tracking(axes, run)
    assert len(axes.get_legend().get_texts()) == 6
    axes = Figure().subplots()
    draw_velocities(axes, run)
    shown = [one.get_ydata().max() for one in axes.get_lines() if len(one.get_xdata()) > 2]
    share = 100.0 * np.abs(run["v"][:, 6:]) / run.robot_info.v_max
    assert max(shown) == pytest.approx(share.max(), rel=0.1)
    axes = Figure().subplots()
    draw_power(axes, run)
    expected = np.einsum("ti,ti->t", run["tau"], run["v"][:, 6:])
    np.testing.assert_allclose(line(axes, "all joints").get_ydata(), expected)


def test_a_spike_of_one_tick_does_not_choose_the_joints():
    values = np.zeros((1000, 3))
    values[0, 0], values[:, 1], values[:, 2] = 1000.0, 2.0, 3.0
    assert largest_joints(values, 2).tolist() == [2, 1]


def test_the_view_from_above_is_as_high_as_its_path(walk):
    run, _ = walk
    points = np.vstack([run["com"][:, :2], *(corners for _, corners in footprints(run))])
    across, along = np.ptp(points, axis=0)
    width, height = top_view_size(run)
    assert (height - 1.0) / (width - 2.0) == pytest.approx(along / across, rel=0.05)


def test_tick_time_plot_shows_period_median_and_failures(folder):
    humanoid = robot()
    rng = np.random.default_rng(0)
    path = folder / "failures.mcap"
    with StreamedLog(path, humanoid) as log:
        for k in range(40):
            tick = random_tick(humanoid, rng, 0.002 * k)
            bad = replace(tick.command, status=Status.INFEASIBLE, explanation="no way")
            tick = replace(
                tick,
                estimator_time=50e-6,
                controller_time=200e-6,
                command=bad if 10 <= k < 13 else tick.command,
            )
            log.record(tick)
    axes = Figure().subplots()
    draw_tick_time(axes, LoggedRun.read(path))
    texts = {text.get_text() for text in axes.texts}
    assert texts == {"budget 2000 µs", "median 250 µs", "p99 250 µs"}
    assert "3 ticks without a solution" in axes.get_title(loc="left") + axes.get_title()
    (mark,) = axes.patches
    assert mark.get_x() == pytest.approx(0.02)


def test_one_call_makes_all_plots(walk, tmp_path, capsys):
    from PIL import Image

    run, _ = walk
    assert main(["plot", str(run.log.path), "--out", str(tmp_path / "new")]) == 0
    paths = [Path(text) for text in capsys.readouterr().out.split()]
    names = ["above", "balance", "forces", "torques", "joints", "timing"]
    assert [p.name for p in paths] == [f"walk_{name}.png" for name in names]
    for path in paths:
        picture = np.asarray(Image.open(path).convert("L"), float)
        assert "above" in path.name or picture.shape[1] == 1650
        assert (picture < 200).mean() > 0.01, "there is hardly anything on it"


def test_a_log_without_balance_quantities_is_plotted(tmp_path):
    humanoid = robot()
    rng = np.random.default_rng(0)
    path = tmp_path / "plain.mcap"
    with StreamedLog(path, humanoid) as log:
        log.record(random_tick(humanoid, rng, 0.0, truth=False))
    paths = plot(LoggedRun.read(path), tmp_path, ".svg")
    assert [p.suffix for p in paths] == [".svg"] * 6
    assert all(p.stat().st_size > 1000 for p in paths)


def test_an_unwritable_folder_is_an_error_with_its_path(walk, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(LogError, match="give another folder"):
        plot(walk[0], tmp_path / "file")


def test_intervals_of_true_values_are_found():
    assert spans(np.array([1, 1, 0, 1, 0, 0, 1], bool)) == [(0, 2), (3, 4), (6, 7)]
    assert spans(np.zeros(3, bool)) == []


def test_diff_of_two_identical_runs_is_empty(walk, folder, capsys):
    run, _ = walk
    logged_walk(folder / "again.mcap", seconds=0.5)
    again = LoggedRun.read(folder / "again.mcap")
    difference = compare(run, again)
    assert difference.divergences == ()
    assert difference.ticks == 250
    assert main(["diff", str(run.log.path), str(run.log.path)]) == 0
    assert "The runs are equal at all 750 common ticks" in capsys.readouterr().out


def test_diff_of_runs_with_other_gains_begins_in_the_commands(walk, folder, capsys):
    run, _ = walk
    path = folder / "gains.mcap"
    logged_walk(path, seconds=0.4, gains=replace(wbc.WalkerGains(), trunk_kp=81.0))
    difference = compare(run, LoggedRun.read(path))
    first = difference.first
    assert (first.stage, first.tick) == ("commanded", 0)
    assert difference.parameters["controller.gains.trunk_kp"] == ("80.0", "81.0")
    # It spreads: what was commanded is measured afterwards, never before.
    measured = [p for p in difference.divergences if p.stage == "measured"]
    assert measured
    assert min(p.tick for p in measured) >= 1
    assert main(["diff", str(run.log.path), str(path)]) == 1
    told = capsys.readouterr().out
    assert "first in a commanded quantity" in told
    assert "the controllers, their parameters or their solvers differ" in " ".join(told.split())
    assert 0 < told.index("controller.gains.trunk_kp") < told.index("The runs diverge")
    assert "Run 2 ends earlier" in told


def test_diff_of_a_pushed_run_begins_in_the_measurements_at_the_push(walk, folder):
    run, _ = walk
    path = folder / "push.mcap"
    logged_walk(path, seconds=0.4, push=(0.3, (0.0, 2.0, 0.0)))
    first = compare(run, LoggedRun.read(path)).first
    assert first.stage == "measured"
    assert first.time == pytest.approx(0.302, abs=0.003)


def made_up(path, change=None, ticks=20):
    """A log of ticks that are the same every time, but for one change."""
    humanoid = robot()
    rng = np.random.default_rng(3)
    with StreamedLog(path, humanoid) as log:
        log.begin()
        for k in range(ticks):
            tick = random_tick(humanoid, rng, 0.002 * k)
            tick = replace(tick, telemetry=telemetry(rng), contact_plan=contact_plan(rng))
            if change is not None and k == 12:
                tick = change(tick)
            log.record(tick)
    return LoggedRun.read(path)


def shifted_knee(tick):
    tau = tick.command.tau.copy()
    tau[4] += 1e-4
    return replace(tick, command=replace(tick.command, tau=tau))


def test_diff_states_joint_time_and_size_of_a_difference(tmp_path):
    a = made_up(tmp_path / "a.mcap")
    b = made_up(tmp_path / "b.mcap", shifted_knee)
    (divergence,) = compare(a, b).divergences
    assert divergence.name == "tau"
    assert divergence.part == a.robot_info.joints[4]
    assert (divergence.tick, divergence.time) == (12, pytest.approx(0.024))
    assert divergence.b - divergence.a == pytest.approx(1e-4)
    assert divergence.largest == pytest.approx(1e-4)
    assert compare(a, b, tolerance=1e-3).divergences == ()


def test_diff_does_not_blame_the_estimators_for_a_dcm_of_the_controller(tmp_path, capsys):
    def shifted_dcm(tick):
        moved = replace(tick.telemetry, dcm=tick.telemetry.dcm + 5e-7)
        return replace(tick, telemetry=moved)

    a, b = made_up(tmp_path / "a.mcap"), made_up(tmp_path / "b.mcap", shifted_dcm)
    assert compare(a, b).first.stage == "intended"
    assert main(["diff", str(a.log.path), str(b.log.path)]) == 1
    assert "estimators" not in capsys.readouterr().out
    assert main(["diff", str(a.log.path), str(b.log.path), "--tolerance", "1e-6"]) == 0
    assert "The runs are equal to within 1e-06 at all 20" in capsys.readouterr().out


@pytest.mark.slow
def test_diff_names_another_command_first(tmp_path, capsys):
    def log(path, value):
        humanoid = robot()
        rng = np.random.default_rng(3)
        with StreamedLog(path, humanoid) as log:
            log.stream.begin_run()
            log.begin()
            for k in range(4):
                log.record(random_tick(humanoid, rng, 0.002 * k))
            log.log.on_event(RunEvent(0.002, "command", "page", 1, "stand", "{}", "accepted"))
            log.log.on_event(RunEvent(0.004, "command", "page", 2, "gain", value, "accepted"))
        return str(path)

    values = (f'{{"task": "com", "gain": "kp", "value": {k}}}' for k in (1, 2))
    logs = [log(tmp_path / name, value) for name, value in zip("ab", values, strict=True)]
    assert main(["diff", *logs]) == 0
    told = capsys.readouterr().out
    assert told.index("The commands differ, first here:") < told.index("The runs are equal")
    assert '1  0.004 s: gain {"task": "com", "gain": "kp", "value": 1} from the page' in told


def test_a_value_that_is_nan_in_one_run_only_is_a_difference(tmp_path):
    a = made_up(tmp_path / "a.mcap")
    b = made_up(
        tmp_path / "b.mcap",
        lambda tick: replace(tick, command=replace(tick.command, wrenches={})),
    )
    (divergence,) = compare(a, b).divergences
    assert divergence.name == "commanded_wrench/left_sole"
    assert np.isnan(divergence.b)


def test_diff_refuses_logs_of_different_robots(walk, tmp_path):
    other = made_up(tmp_path / "other.mcap", ticks=3)
    with pytest.raises(LogError, match="robots with different joints cannot be compared"):
        compare(walk[0], other)


def test_wbc_log_prints_the_content_of_a_log(walk, capsys):
    run, _ = walk
    assert main(["log", str(run.log.path)]) == 0
    told = capsys.readouterr().out
    assert "g1, 1.5 s" in told
    assert "/joint_states" in told
    assert "gains.com_weight" in told
    assert wbc.__version__ in told


def test_wbc_log_repairs_a_copy_without_changing_the_log(walk, tmp_path, capsys):
    run, _ = walk
    broken = tmp_path / "broken.mcap"
    data = run.log.path.read_bytes()
    broken.write_bytes(data[: int(0.9 * len(data))])
    cut = broken.read_bytes()
    assert main(["log", str(broken)]) == 0
    assert "The log was interrupted" in capsys.readouterr().out
    assert main(["log", str(broken), "--repair"]) == 0
    assert "the original was interrupted" in capsys.readouterr().out
    assert broken.read_bytes() == cut
    copy = tmp_path / "broken-repaired.mcap"
    assert LoggedRun.read(copy).log.complete
    assert main(["log", str(broken), "--repair"]) == 2, "the copy is there already"
    assert "--out" in capsys.readouterr().err
    assert main(["log", str(broken), "--out", str(broken)]) == 2
    assert main(["log", str(broken), "--out", str(tmp_path / "other.mcap")]) == 0
    assert (tmp_path / "other.mcap").read_bytes() == copy.read_bytes()
    assert broken.read_bytes() == cut


@pytest.mark.parametrize("command", ["plot", "log", "replay"])
def test_a_missing_log_is_an_error_of_one_line(command, capsys):
    assert main([command, "nowhere.mcap"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "nowhere.mcap" in error


def test_wbc_walk_writes_its_log(tmp_path, capsys):
    path = tmp_path / "deep" / "stand.mcap"
    arguments = ["stand", "--robot", "g1", "--duration", "0.3", "--no-view", "--log", str(path)]
    assert main(arguments) == 0
    assert str(path) in capsys.readouterr().out
    run = LoggedRun.read(path)
    assert len(run) == 150
    assert run.log.tables["report"]["survived"] == "True"


def test_the_robot_of_a_log_is_found_by_name_or_path(walk, tmp_path):
    run, _ = walk
    assert logged_robot(run.robot_info).joint_names == run.robot_info.joints
    # One of one's own, in a place of its own, with a joint welded.
    source = wbc.load("simple_humanoid").urdf_path
    own = Path(shutil.copy(source, tmp_path / "own.urdf"))
    loaded = wbc.load("simple_humanoid")
    welded = loaded.joint_names[-1]
    left, right = (sole.link for sole in loaded.soles)
    mine = wbc.load(own, left_foot=left, right_foot=right, fixed_joints=[welded], name="mine")
    rng = np.random.default_rng(0)
    with StreamedLog(tmp_path / "mine.mcap", mine) as log:
        log.record(random_tick(mine, rng, 0.0))
    info = LoggedRun.read(tmp_path / "mine.mcap").robot_info
    assert logged_robot(info).joint_names == mine.joint_names
    os.remove(own)
    with pytest.raises(LogError, match="give its name or URDF with --robot"):
        logged_robot(info)
    with pytest.raises(LogError, match=f"differ from those of the robot in the log .'{welded}'"):
        logged_robot(info, "simple_humanoid")


def test_wbc_replay_writes_a_log_as_a_page(walk, tmp_path, capsys):
    run, _ = walk
    path = tmp_path / "walk.html"
    assert main(["replay", str(run.log.path), "--html", str(path)]) == 0
    assert str(path) in capsys.readouterr().out
    assert '"time":1.498' in path.read_text("utf-8")


def test_wbc_plot_draws_any_quantity_by_its_name(walk, tmp_path, capsys):
    run, _ = walk
    path = str(run.log.path)
    assert main(["plot", path, "--out", str(tmp_path), "--signal", "foot_wrench/left_sole"]) == 0
    assert capsys.readouterr().out.strip().endswith("_foot_wrench_left_sole.png")
    assert main(["plot", path, "--signal", "joint_positon"]) != 0
    assert "did you mean 'joint_position'" in capsys.readouterr().err


def test_a_negative_tolerance_is_refused(walk):
    run, _ = walk
    with pytest.raises(LogError, match="tolerance = -1"):
        compare(run, run, -1.0)
