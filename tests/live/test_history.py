"""The last minutes of a session: samples, the extremes between them, and files of them."""

import tracemalloc

import numpy as np
import pytest

import wbc
from wbc.live.history import PERIOD, History
from wbc.live.saving import Stretch
from wbc.live.signals import signal_limits, signal_places
from wbc.log import LoggedRun
from wbc.runtime.controller_inputs import NAME, controller_inputs
from wbc.runtime.mode import Mode
from wbc.runtime.quantities import QUANTITIES
from wbc.runtime.schema import Schema, declared_columns

DT = 0.002


@pytest.fixture(scope="module")
def robot():
    return wbc.load("simple_humanoid")


@pytest.fixture(scope="module")
def schema(robot):
    return Schema(tuple(column for column, _ in declared_columns(robot, QUANTITIES)))


def ticks(robot, schema, times, run=1):
    records = np.zeros(len(times), schema.dtype)
    records["time"], records["run"], records["q"] = times, run, robot.q_nominal
    for name in ("support", "footsteps", "swing_path", "contact_wrenches"):
        records[name] = np.nan
    return records


def test_no_extreme_between_two_samples_is_lost(robot, schema):
    history = History(robot, DT)
    records = ticks(robot, schema, DT * np.arange(1000))
    records["dcm_error"] = 0.01
    records["dcm_error"][333], records["dcm_error"][334] = 0.5, -0.5
    for start in range(0, 1000, 7):
        history.add(records[start : start + 7], schema)
    assert len(history) == 100
    place = signal_places(schema)["dcm_error, m"]
    for points, length in ((10_000, 100), (20, 40)):  # all samples; the older ones joined
        (series,) = history.series([place], 0, points)
        assert len(series.time) == length
        assert (series.high.max(), series.low.min()) == (0.5, -0.5)
        assert (np.diff(series.time) > 0).all()
    (new,) = history.series([place], 98, 10_000)
    assert len(new.time) == 2


def test_the_time_of_a_session_goes_on_over_resets_and_stands_still_after_a_fall(robot, schema):
    history = History(robot, DT)
    history.add(ticks(robot, schema, DT * np.arange(506)), schema)
    fallen = ticks(robot, schema, np.full(30, 1.01))
    fallen["mode"] = Mode.FALLEN
    history.add(fallen, schema)
    assert history.end == pytest.approx(1.01)  # the last tick before the fall is kept
    history.add(ticks(robot, schema, DT * np.arange(500), run=2), schema)
    assert history.end == pytest.approx(2.01, abs=0.02)
    assert history.starts[2] == pytest.approx(1.012)
    assert (history.at(0.9).run, history.at(1.5).run) == (1, 2)
    assert history.at(1.5).time == pytest.approx(1.5 - 1.012, abs=0.021)
    assert history.at(-5.0).time == pytest.approx(0.018)


def test_its_memory_is_bounded(robot, schema):
    history = History(robot, DT, duration=20.0)
    records = ticks(robot, schema, DT * np.arange(500))
    for second in range(60):
        records["time"] = second + DT * np.arange(500)
        history.add(records, schema)
    assert 20.0 <= history.end - history.start <= 40.0
    records, times = history.stretch(55.0, 56.0)
    assert len(records) == 50 == len(times)
    assert records["time"] == pytest.approx(times)


def test_a_stretch_becomes_a_log_and_a_film(robot, schema, tmp_path, monkeypatch):
    monkeypatch.setattr("os.nice", lambda _: 0)
    records = ticks(robot, schema, 5.0 + 0.02 * np.arange(100))
    stretch = Stretch(robot, np.empty((0, 6)), schema, records, 7.0 + 0.02 * np.arange(100), (), ())
    stretch.write("log", tmp_path / "a.mcap")
    run = LoggedRun.read(tmp_path / "a.mcap")
    assert run.title == f"{robot.name}, 7.0 s to 9.0 s of a session"
    assert run.time == pytest.approx(stretch.time)
    assert run["q"][50] == pytest.approx(robot.q_nominal)
    stretch.write("film", tmp_path / "a.html")
    assert "wbc.player" in (tmp_path / "a.html").read_text()


def test_limits_of_signals_are_those_of_the_joints_and_the_period(robot, schema):
    limits = signal_limits(schema, robot, DT)
    assert limits["controller_time, s"] == (None, DT)
    name = robot.joint_names[3]
    assert limits[f"tau: {name}, N·m"] == (-robot.tau_max[3], robot.tau_max[3])
    assert limits[f"q: {name}, m, rad"] == (robot.q_min[3], robot.q_max[3])
    assert "q: x, m, rad" not in limits
    assert set(limits) <= set(signal_places(schema))


def noisy(robot, schema, times, generator):
    """Ticks in which every number is noise, which hardly compresses."""
    records = ticks(robot, schema, times)
    for column in schema.numbers:
        if column.name not in ("time", "run", "mode"):
            shape = records[column.name].shape
            records[column.name] = generator.standard_normal(shape)
    if NAME in schema.by_name:
        records[NAME] = np.sin(np.arange(records[NAME].shape[1]))
    return records


def test_ten_minutes_take_less_than_100_mb():
    robot = wbc.load("talos")
    quantities = (*QUANTITIES, controller_inputs(robot))
    schema = Schema(tuple(column for column, _ in declared_columns(robot, quantities)))
    history, generator = History(robot, PERIOD), np.random.default_rng(0)
    sizes = []
    tracemalloc.start()
    for block in range(24):
        times = 2.0 * block + PERIOD * np.arange(100)
        history.add(noisy(robot, schema, times, generator), schema)
        sizes.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    start, growth = sizes[-1], (sizes[-1] - sizes[-5]) / 400
    assert start + 30_000 * growth < 100e6


def test_old_samples_are_those_that_were_added(robot, schema):
    history = History(robot, PERIOD)
    generator = np.random.default_rng(0)
    added = noisy(robot, schema, PERIOD * np.arange(2500), generator)
    added["contact_names"][:, 0], added["text"] = b"left_sole", b"walking"
    history.add(added, schema)
    kept, times = history.stretch(0.0, 100.0)
    assert times == pytest.approx(added["time"])
    for name in schema.dtype.names:
        column = schema.by_name.get(name)
        same = added[name] if column is None or not column.single else added[name].astype("f4")
        old = slice(None, 2400) if column is not None and column.single else slice(None)
        np.testing.assert_array_equal(kept[name][old], same[old])
    assert history.at(3.0).text == "walking"
    np.testing.assert_array_equal(history.at(3.0).q, added["q"][150])
    place = signal_places(schema)["dcm_error, m"]
    (series,) = history.series([place], 0, 10_000)
    assert series.time[-1] == times[-1]
    assert (np.diff(series.time) > 0).all()
    for values, extreme in ((series.low, np.min), (series.high, np.max)):
        # By tenths of a second, of which older points comprise one each.
        of_series = values[: (series.time < 10.0).sum()]
        expected = extreme(added["dcm_error"][:500].reshape(-1, 5), axis=1).astype("f4")
        np.testing.assert_array_equal(of_series, expected)
    (new,) = history.series([place], 2450, 10_000)
    assert len(new.time) == 50
