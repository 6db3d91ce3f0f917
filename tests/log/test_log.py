"""What a log holds is what happened, for every reader."""

import importlib.util
import json
import logging
import os
import shutil
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from logtools import StreamedLog, contact_plan, random_tick, robot, telemetry
from needs import need

import wbc
from wbc.command import Status
from wbc.errors import MissingExtra
from wbc.estimation import Estimate
from wbc.log import FlightRecorder, LogError, repair
from wbc.log.reader import Log
from wbc.log.run import LoggedRun
from wbc.log.topic_table import TopicTable
from wbc.messages import message_type
from wbc.runtime.schema import SchemaError
from wbc.sim import Mujoco

ROOT = Path(wbc.__file__).parent.parent
TICKS = 60


@pytest.fixture(scope="module")
def humanoid():
    return robot()


@pytest.fixture(scope="module")
def made_up(humanoid, tmp_path_factory):
    """Ticks of random numbers, and the log of them."""
    rng = np.random.default_rng(0)
    path = tmp_path_factory.mktemp("log") / "deep" / "made_up.mcap"
    ticks = []
    with StreamedLog(path, humanoid) as log:
        log.begin()
        for k in range(TICKS):
            bad = k % 10 == 3
            tick = random_tick(
                humanoid,
                rng,
                0.002 * k,
                status=Status.INFEASIBLE if bad else Status.OK,
                explanation=f"rows {k} and ω conflict" if bad else "",
                truth=k != 5,
                contacts=("left_sole",) if k < 30 else ("right_sole", "left hand/grip"),
            )
            plan = contact_plan(rng) if k % 17 == 0 else None
            tick = replace(tick, telemetry=telemetry(rng), contact_plan=plan, period=0.002)
            log.record(tick)
            ticks.append(tick)
    return ticks, Log(path)


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    """A short walk in physics, its log, and its report."""
    g1 = wbc.load("g1")
    walker = wbc.Walker(g1)
    walker.velocity = (0.2, 0.0, 0.1)
    path = tmp_path_factory.mktemp("walk") / "walk.mcap"
    with FlightRecorder(path, g1) as log:
        report = wbc.run(walker, Mujoco(g1, dt=walker.dt, seed=3), 1.6, observers=[log])
    return g1, path, report


def test_state_torques_and_balance_are_logged_bit_by_bit(humanoid, made_up):
    ticks, log = made_up
    run = LoggedRun(log)
    assert (run["q"] == [t.estimate.state.q for t in ticks]).all()
    assert (run["v"] == [t.estimate.state.v for t in ticks]).all()
    assert (run["tau"] == [t.command.tau for t in ticks]).all()
    for i, sole in enumerate(s.name for s in humanoid.soles):
        logged = run[f"foot_wrench/{sole}"]
        assert (logged == [t.measurement.foot_wrenches[sole] for t in ticks]).all(), i
    for name in ("com", "dcm", "dcm_reference", "zmp"):
        assert (run[name] == [getattr(t.telemetry, name) for t in ticks]).all()
    np.testing.assert_allclose(run.time, [t.time for t in ticks], atol=1e-9)


def test_sensors_and_targets_are_logged_in_single_precision(made_up):
    ticks, log = made_up
    for topic, field, values in (
        ("/joint_targets", "position", [t.command.q_target for t in ticks]),
        ("/joint_targets", "velocity", [t.command.v_target for t in ticks]),
        ("/command/acceleration", "data", [t.command.acceleration for t in ticks]),
        ("/sensors/joint_states", "position", [t.measurement.joint_position for t in ticks]),
        ("/sensors/joint_states", "velocity", [t.measurement.joint_velocity for t in ticks]),
        ("/imu", "angular_velocity", [t.measurement.gyro for t in ticks]),
        ("/imu", "linear_acceleration", [t.measurement.accelerometer for t in ticks]),
    ):
        assert (log[topic].numbers(field) == np.array(values, np.float32)).all(), (topic, field)


def test_ground_truth_is_logged_if_the_plant_has_it(made_up):
    ticks, log = made_up
    stamps = log["/ground_truth/odom"].stamps
    logged = log["/ground_truth/odom"].numbers("pose.pose.position")
    assert 0.01e9 not in stamps  # the tick without truth
    assert len(stamps) > 5
    for stamp, position in zip(stamps, logged, strict=True):
        truth = ticks[round(stamp / 2e6)].truth
        assert (position == truth.q[:3].astype(np.float32)).all()


def test_quantities_that_are_not_sent_in_every_tick_keep_their_latest_value(made_up):
    ticks, log = made_up
    run = LoggedRun(log)
    sent = np.searchsorted(run.stamps, log["/ground_truth/odom"].stamps)
    for k in (sent[1], sent[1] + 1, sent[2] - 1):
        assert (run["true_q"][k] == ticks[sent[1]].truth.q.astype(np.float32)).all()
    assert np.isnan(run["commanded_wrench/left_sole"][30:]).all()


def test_timing_status_and_explanation_of_every_tick_are_logged(made_up):
    ticks, log = made_up
    run = LoggedRun(log)
    assert run["tick"].tolist() == list(range(TICKS))
    assert run["estimator_time"].tolist() == [t.estimator_time for t in ticks]
    assert run["controller_time"].tolist() == [t.controller_time for t in ticks]
    assert (run["period"] > 0).all()
    assert set(run["dcm_error"]) == {0.25}
    assert set(run["steps"]) == {3}
    assert set(run["velocity_command"][:, 2]) == {0.3}
    assert set(run["phase"]) == {2}
    statuses = run["status"]
    assert [bool(s) for s in statuses] == [t.command.status is not Status.OK for t in ticks]


def test_commanded_wrenches_of_any_contact_are_logged(made_up):
    ticks, log = made_up
    left = LoggedRun(log)["commanded_wrench/left_sole"]
    assert (left[:30] == [t.command.wrenches["left_sole"] for t in ticks[:30]]).all()
    assert np.isnan(left[30:]).all()
    # A name that is none in ROS is told in the frame.
    topic = "/command/wrench/left_hand_grip"
    assert log[topic].first.header.frame_id == "left hand/grip"
    logged = log[topic].numbers("wrench")
    assert (logged == [t.command.wrenches["left hand/grip"] for t in ticks[30:]]).all()


def test_contact_plans_are_logged_thirty_times_a_second(made_up):
    ticks, log = made_up
    run = LoggedRun(log)
    assert run.plan_stamps.tolist() == [0, 34_000_000, 68_000_000, 102_000_000]
    plan, logged = ticks[17].contact_plan, run.plans[1]
    np.testing.assert_allclose(logged.support, plan.support, rtol=1e-6)
    np.testing.assert_array_equal(logged.swing_path, plan.swing_path)
    assert [s.side for s in logged.footsteps] == ["left", "right"]
    for mine, theirs in zip(logged.footsteps, plan.footsteps, strict=True):
        np.testing.assert_array_equal(mine.position, theirs.position)
        assert mine.yaw == pytest.approx(theirs.yaw)
    right = log["/footsteps/right"].messages()[1]
    assert [p.position.x for p in right.poses] == [plan.footsteps[1].position[0]]


def test_a_snapshot_of_a_log_equals_that_of_the_tick(humanoid, made_up):
    ticks, log = made_up
    snapshot = LoggedRun(log).at(0.034)
    assert (snapshot.q == ticks[17].estimate.state.q).all()
    assert (snapshot.telemetry.dcm == ticks[17].telemetry.dcm).all()
    assert snapshot.telemetry.phase == "left"
    assert set(snapshot.wrenches) == {s.name for s in humanoid.soles}
    assert snapshot.status is ticks[17].command.status


def test_parameters_and_versions_are_logged(made_up):
    _, log = made_up
    assert log.tables["versions"]["wbc"] == wbc.__version__
    assert log.tables["versions"]["pin"].startswith("3.")
    assert log.tables["controller"]["gains.stiffness"] == "3.5"
    assert log.tables["plant"]["seed"] == "7"
    assert log.tables["run"]["dt"] == "0.002"
    assert log.tables["run"]["command"]


def test_a_log_describes_its_robot(humanoid, made_up):
    _, log = made_up
    info = log.robot_info()
    assert info.joints == humanoid.joint_names
    np.testing.assert_array_equal(info.tau_max, humanoid.tau_max)
    np.testing.assert_array_equal(info.q_min, humanoid.q_min)
    assert info.soles[1] == (humanoid.soles[1].half_length, humanoid.soles[1].half_width)
    assert log["/robot_description"].first.data == humanoid.urdf_path.read_text("utf-8")


def test_logged_centre_of_pressure_is_that_of_both_feet(humanoid, tmp_path):
    left, right = (sole.name for sole in humanoid.soles)
    state = humanoid.standing()
    rng = np.random.default_rng(1)
    tick = random_tick(humanoid, rng, 0.0)
    # 300 N at 3 cm before the left sole's centre, 100 N in the right one's.
    wrenches = {
        left: np.array([5.0, 2.0, 300.0, 0.0, -9.0, 1.0]),
        right: np.array([0.0, 0.0, 100.0, 0.0, 0.0, 0.0]),
    }
    tick.measurement.foot_wrenches.update(wrenches)
    ticks = [replace(tick, time=t, estimate=Estimate(state), truth=None) for t in (0.0, 0.002)]
    path = tmp_path / "cop.mcap"
    with StreamedLog(path, humanoid) as log:
        log.record(ticks[0])
        tick.measurement.foot_wrenches.update(dict.fromkeys(wrenches, np.zeros(6)))  # in the air
        log.record(ticks[1])
    kin = wbc.Kinematics(humanoid, state)
    ahead = kin.frame(left).act(np.array([0.03, 0.0, 0.0]))
    expected = 0.75 * ahead + 0.25 * kin.frame(right).translation
    run = LoggedRun.read(path)
    np.testing.assert_allclose(run["cop"][0], expected, atol=1e-12)
    assert np.isnan(run["cop"][1]).all()
    np.testing.assert_allclose(
        run[f"sole_pose/{left}"][0, :3], kin.frame(left).translation, atol=1e-12
    )
    # Nobody told the centre of mass: it is computed.
    np.testing.assert_allclose(run["com"][0], kin.p_com, atol=1e-12)


def test_a_walk_is_logged_tick_by_tick_with_its_report(walk):
    g1, path, report = walk
    run = LoggedRun.read(path)
    assert run.log.complete
    assert len(run) == 800
    np.testing.assert_allclose(np.diff(run.time), 0.002, atol=2e-9)
    assert run.log.tables["report"]["survived"] == "True"
    assert float(run.log.tables["report"]["duration_s"]) == report.duration_s
    assert 1e6 * np.median(run["controller_time"]) == pytest.approx(report.tick_p50_us)
    assert run["steps"][-1] == report.steps
    # The ticks of a loop that was not in real time took less than all of the wall's time.
    assert (run["period"][1:] > run["controller_time"][1:]).all()
    force = sum(run[f"foot_wrench/{sole.name}"][:, 2] for sole in g1.soles)
    assert np.mean(force) == pytest.approx(g1.weight, rel=0.05)
    com = pin.centerOfMass(g1.model, g1.model.createData(), run["q"][400])
    np.testing.assert_allclose(run["com"][400], com, atol=1e-9)


def test_logging_does_not_change_a_run(walk):
    g1, path, _ = walk
    walker = wbc.Walker(g1)
    walker.velocity = (0.2, 0.0, 0.1)
    plant = Mujoco(g1, dt=walker.dt, seed=3)
    truths = []
    wbc.run(walker, plant, 0.2, before_tick=lambda _: truths.append(plant.ground_truth()))
    log = Log(path)
    ticks = log["/ground_truth/odom"].stamps[:20] // 2_000_000
    assert ticks.tolist() == list(range(0, 100, 5))
    positions = np.array([truths[k].q[:3] for k in ticks], np.float32)
    logged = log["/ground_truth/odom"].numbers("pose.pose.position")[:20]
    np.testing.assert_array_equal(logged, positions)
    # What the controller saw was an estimate.
    assert (LoggedRun(log)["q"][ticks, :3] != positions).any(axis=1).all()


def test_every_message_is_read_by_rosbags(walk):
    rosbags = pytest.importorskip("rosbags.highlevel")
    _, path, _ = walk
    with rosbags.AnyReader([path]) as reader:
        assert {c.topic for c in reader.connections} == set(Log(path).topics)
        for connection in reader.connections:
            expected = message_type(connection.msgtype).type_hash()
            assert connection.digest in ("", expected), connection.topic
        for connection, stamp, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            again = reader.typestore.serialize_cdr(message, connection.msgtype)
            assert bytes(again) == data, connection.topic
            if hasattr(message, "header"):
                header = message.header.stamp
                assert header.sec * 10**9 + header.nanosec == stamp


def test_the_reference_reader_finds_order_schemas_and_checksums(walk):
    from mcap.reader import make_reader

    _, path, _ = walk
    log = Log(path)
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        counts, last = {}, 0
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            assert schema.encoding == "ros2msg"
            assert schema.data.decode() == message_type(schema.name).schema()
            assert message.log_time >= last, "not in the order of time"
            last = message.log_time
            counts[channel.topic] = counts.get(channel.topic, 0) + 1
        assert counts == {topic: len(table) for topic, table in log.topics.items()}
        statistics = reader.get_summary().statistics
        assert statistics.message_count == sum(counts.values())
        assert {m.name for m in reader.iter_metadata()} == set(log.tables)
        assert {a.name for a in reader.iter_attachments()} == set(log.files)


def test_the_javascript_reader_reads_the_same_messages(walk):
    node = shutil.which("node")
    need(node, "node is not installed")
    folder = Path(os.environ.get("WBC_NODE_MODULES", ROOT / "tests" / "npm"))
    need((folder / "node_modules").is_dir(), f"no readers: run  npm install --prefix {folder}")
    _, path, _ = walk
    script = ROOT / "tests" / "npm" / "read_log.mjs"
    command = [node, str(script), str(path), "/joint_states", "effort"]
    environment = {**os.environ, "WBC_NODE_MODULES": str(folder)}
    result = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=120)
    assert result.returncode == 0, result.stderr
    found = json.loads(result.stdout)
    log = Log(path)
    assert found["profile"] == "ros2"
    assert found["counts"] == {topic: len(table) for topic, table in log.topics.items()}
    assert found["last"] == LoggedRun(log).stamps[-1]
    assert found["metadata"] == log.tables
    np.testing.assert_array_equal(found["values"], log["/joint_states"].numbers("effort"))


def test_a_log_continues_after_a_reset_of_the_plant(humanoid, tmp_path):
    rng = np.random.default_rng(2)
    path = tmp_path / "twice.mcap"
    with StreamedLog(path, humanoid) as log:
        for _ in range(2):
            log.begin()
            for k in range(5):
                log.record(random_tick(humanoid, rng, 0.002 * k))
    np.testing.assert_allclose(LoggedRun.read(path).time, 0.002 * np.arange(10), atol=1e-9)


def test_a_controller_without_telemetry_is_logged(humanoid, tmp_path):
    rng = np.random.default_rng(2)
    path = tmp_path / "plain.mcap"
    with StreamedLog(path, humanoid) as log:
        for k in range(3):
            log.record(random_tick(humanoid, rng, 0.002 * k, truth=False))
    run = LoggedRun.read(path)
    assert len(run) == 3
    assert "/balance/dcm" not in run.log
    assert np.isnan(run["dcm"]).all()
    assert np.isnan(run["dcm_error"]).all()


def test_a_plant_with_a_nan_state_is_logged_to_the_end(humanoid, tmp_path):
    rng = np.random.default_rng(2)
    path = tmp_path / "lost.mcap"
    with StreamedLog(path, humanoid) as log:
        for k in range(4):
            tick = random_tick(humanoid, rng, 0.002 * k if k < 2 else float("nan"))
            nowhere = wbc.State(np.full(humanoid.nq, np.nan), np.full(humanoid.nv, np.inf))
            log.record(tick if k < 2 else replace(tick, estimate=Estimate(nowhere)))
    run = LoggedRun.read(path)
    assert len(run) == 4
    assert np.isnan(run["q"][2:]).all()
    assert np.isfinite(run["q"][:2]).all()
    assert (np.diff(run.time) >= 0.0).all()


def test_arrays_of_wrong_size_are_refused_by_name(humanoid, tmp_path):
    rng = np.random.default_rng(2)
    tick = random_tick(humanoid, rng, 0.0)
    bad = replace(tick.command, tau=tick.command.tau[:3])
    log = StreamedLog(tmp_path / "bad.mcap", humanoid)
    with log, pytest.raises(SchemaError, match=r"command\.tau .* has shape \(3,\)"):
        log.record(replace(tick, command=bad))


def test_an_unwritable_path_is_an_error_before_the_run(humanoid, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(LogError, match="give another path"):
        StreamedLog(tmp_path / "file" / "run.mcap", humanoid)
    with pytest.raises(LogError, match="give another path"):
        StreamedLog(tmp_path, humanoid)


@pytest.mark.parametrize("content", [b"", b"no log", b"\x89MCAP0\r\n"])
def test_a_file_that_is_no_log_is_refused(tmp_path, content):
    path = tmp_path / "no.mcap"
    path.write_bytes(content)
    with pytest.raises(LogError, match=r"no\.mcap"):
        LoggedRun.read(path)
    with pytest.raises(LogError, match=r"none\.mcap"):
        LoggedRun.read(tmp_path / "none.mcap")


@pytest.mark.parametrize("package", ["mcap", "rosbags"])
def test_a_missing_package_is_named_with_the_command_that_brings_it(package, tmp_path, monkeypatch):
    find_spec = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == package else find_spec(name)
    )
    for use in (Log, lambda path: repair(path, path), lambda path: FlightRecorder(path, robot())):
        with pytest.raises(MissingExtra, match=rf"'{package}' .* pip install 'wbc\[log\]'"):
            use(tmp_path / "any.mcap")


def test_an_unknown_topic_or_field_is_refused_with_the_known_ones(made_up):
    _, log = made_up
    with pytest.raises(LogError, match="did you mean '/joint_states'"):
        log["/joint_state"].numbers("position")
    with pytest.raises(LogError, match="it has: header"):
        log["/joint_states"].numbers("force")


@pytest.mark.parametrize("padding", [0, 1, 3])
def test_messages_with_padding_at_their_end_are_read(padding):
    table = TopicTable("/joint_states", "sensor_msgs/msg/JointState")
    for k in range(3):
        message = message_type(table.type_name)(name=["knee", "hip"], position=[k, 2.0])
        table.add(k, message.encode() + bytes(padding))
    np.testing.assert_array_equal(table.numbers("position"), [[0, 2], [1, 2], [2, 2]])


def test_overwritten_ticks_are_counted_and_reported(humanoid, tmp_path, caplog):
    rng = np.random.default_rng(2)
    path = tmp_path / "slow.mcap"
    log = StreamedLog(path, humanoid, capacity=32)
    os.kill(log.log.pid, signal.SIGSTOP)
    ticks = [random_tick(humanoid, rng, 0.002 * k) for k in range(100)]
    for tick in ticks:
        log.record(tick)
    os.kill(log.log.pid, signal.SIGCONT)
    with caplog.at_level(logging.WARNING):
        log.close()
    assert "68 of 100 ticks are not in" in caplog.text
    run = LoggedRun.read(path)
    assert run.log.tables["log"]["dropped"] == "68"
    assert run["tick"].tolist() == list(range(68, 100))  # the latest are there


def test_the_loops_process_loads_no_package_of_the_log():
    code = """
import sys, wbc
from wbc.log import FlightRecorder
robot = wbc.load("simple_humanoid")
with FlightRecorder(sys.argv[1], robot) as log:
    pass
unwanted = {"mcap", "rosbags", "zstandard", "mujoco", "meshcat", "matplotlib"}
print(sorted(unwanted & set(sys.modules)))
"""
    result = subprocess.run(
        [sys.executable, "-c", code, os.devnull + "x"], capture_output=True, text=True
    )
    assert "[]" in result.stdout or "give another path" in result.stderr


def test_every_logged_type_is_of_ros_or_of_wbc_msgs(walk):
    _, path, _ = walk
    packages = {table.type_name.split("/")[0] for table in Log(path).topics.values()}
    assert packages <= {
        "sensor_msgs", "geometry_msgs", "nav_msgs", "std_msgs", "tf2_msgs", "wbc_msgs",
    }  # fmt: skip
    for table in Log(path).topics.values():
        assert message_type(table.type_name)().encode()
