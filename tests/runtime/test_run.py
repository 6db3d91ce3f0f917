"""The loop: who is asked what, when it ends, and what the report says."""

from __future__ import annotations

import gc
import json
import time

import numpy as np
import pytest

import wbc
from wbc.errors import WbcError
from wbc.runtime.loop import StopRun
from wbc.runtime.statistics import _distance_and_speeds
from wbc.runtime.tick import Tick
from wbc.sim import Mujoco, SensorNoise


class HoldPosture:
    """A controller of one's own: joint springs around where it started."""

    def __init__(self, robot: wbc.Robot) -> None:
        self._robot = robot
        self.states: list[wbc.State] = []

    def reset(self, state: wbc.State) -> None:
        self._kin = wbc.Kinematics(self._robot, state)
        self._q = state.q[7:].copy()
        # Half the weight on each foot, and springs for the rest.
        half = self._kin.mass * 4.905
        J = sum(self._kin.jacobian(s.name)[2] for s in self._robot.soles)
        self._gravity = self._kin.bias_forces[6:] - half * np.asarray(J)[6:]

    def step(self, estimate: wbc.Estimate) -> wbc.Command:
        state = estimate.state
        self.states.append(state)
        robot = self._robot
        stiff = 20.0 * robot.tau_max
        tau = self._gravity + stiff * (self._q - state.q[7:]) - 0.1 * stiff * state.v[6:]
        tau = np.clip(tau, -robot.tau_max, robot.tau_max)
        na = robot.na
        return wbc.Command(tau, np.zeros(robot.nv), {}, np.zeros(na), np.zeros(na))


class FrozenPlant:
    """A plant of one's own that stands still and counts its commands."""

    def __init__(self, robot: wbc.Robot, dt: float = 0.002) -> None:
        self.robot, self.dt = robot, dt
        self.commands: list[wbc.Command] = []

    @property
    def time(self) -> float:
        return len(self.commands) * self.dt

    def measure(self) -> wbc.Measurement:
        na, weight = self.robot.na, self.robot.mass * 9.81
        wrench = np.array([0.0, 0.0, 0.5 * weight, 0.0, 0.0, 0.0])
        return wbc.Measurement(
            self.time,
            self.robot.q_nominal[7:].copy(),
            np.zeros(na),
            np.zeros(3),
            np.array([0.0, 0.0, 9.81]),
            {s.name: wrench.copy() for s in self.robot.soles},
        )

    def step(self, command: wbc.Command) -> None:
        self.commands.append(command)


class Album:
    """An observer that keeps the ticks."""

    def __init__(self) -> None:
        self.ticks: list[Tick] = []
        self.report: wbc.Report | None = None

    def begin(self, controller: object, plant: object) -> None:
        self.ticks.clear()

    def observe(self, tick: Tick) -> None:
        self.ticks.append(tick)

    def end(self, report: wbc.Report) -> None:
        self.report = report


@pytest.fixture(scope="module")
def robot() -> wbc.Robot:
    return wbc.load("simple_humanoid")


def test_user_defined_controller_stands_in_mujoco(robot: wbc.Robot) -> None:
    controller = HoldPosture(robot)
    with Mujoco(robot, noise=SensorNoise.none()) as plant:
        report = wbc.run(controller, plant, 1.0)
    assert report.survived, report.table()
    assert len(controller.states) == 500
    assert report.steps == 0
    assert report.distance_m < 0.05


def test_walker_runs_in_a_user_defined_plant(robot: wbc.Robot) -> None:
    plant = FrozenPlant(robot)
    report = wbc.run(wbc.Walker(robot), plant, 0.2)
    assert report.survived
    assert len(plant.commands) == 100
    weight = robot.mass * 9.81
    carried = sum(w[2] for w in plant.commands[-1].wrenches.values())
    assert carried == pytest.approx(weight, rel=0.1)


def test_observers_see_every_tick_and_thirty_contact_plans_a_second(robot: wbc.Robot) -> None:
    album, other = Album(), Album()
    with Mujoco(robot) as plant:
        report = wbc.run(wbc.Walker(robot), plant, 0.5, observers=[album, other])
    assert [tick.index for tick in album.ticks] == list(range(250))
    assert album.ticks == other.ticks
    assert album.report is other.report is report
    plans = [tick.contact_plan for tick in album.ticks if tick.contact_plan is not None]
    assert 14 <= len(plans) <= 17
    assert plans[-1].support.shape[0] >= 4
    last = album.ticks[-1]
    assert set(last.measurement.foot_wrenches) == {"left_sole", "right_sole"}
    assert np.isfinite(last.telemetry.com).all()
    assert last.telemetry.dcm_error < 0.05


def test_controller_without_telemetry_has_unknown_telemetry(robot: wbc.Robot) -> None:
    album = Album()
    wbc.run(HoldPosture(robot), FrozenPlant(robot), 0.02, observers=[album])
    assert np.isnan(album.ticks[-1].telemetry.dcm).all()
    assert all(tick.contact_plan is None for tick in album.ticks)


def test_control_periods_that_differ_from_the_plants_are_refused(robot: wbc.Robot) -> None:
    with pytest.raises(wbc.WbcError, match=r"Walker\.dt = 0\.002 s differs .* 0\.004 s"):
        wbc.run(wbc.Walker(robot, dt=0.002), FrozenPlant(robot, dt=0.004), 0.1)
    estimator = wbc.Estimator(robot, 0.001)
    with pytest.raises(wbc.WbcError, match=r"Estimator\.dt = 0\.001 s differs"):
        wbc.run(wbc.Walker(robot), FrozenPlant(robot), 0.1, estimator=estimator)


def test_real_time_run_takes_its_duration_of_wall_time(robot: wbc.Robot) -> None:
    plant = FrozenPlant(robot, dt=0.01)
    begun = time.perf_counter()
    report = wbc.run(HoldPosture(robot), plant, 0.5, real_time=True)
    assert time.perf_counter() - begun > 0.48
    assert report.lateness_p99_us > 0.0


def test_callback_may_change_commands_and_end_the_run(robot: wbc.Robot) -> None:
    times: list[float] = []

    def before_tick(now: float) -> None:
        times.append(now)
        if now > 0.1:
            raise StopRun("enough")

    report = wbc.run(HoldPosture(robot), FrozenPlant(robot), 1.0, before_tick=before_tick)
    assert not report.survived
    assert report.fell_at_s is None
    assert "enough" in report.table()
    assert times == sorted(times)


def test_progress_is_reported_about_ten_times_a_second(robot: wbc.Robot) -> None:
    told = []
    wbc.run(HoldPosture(robot), FrozenPlant(robot), 1.0, progress=told.append)
    assert 9 <= len(told) <= 11
    assert told[-1].duration == 1.0


def test_report_counts_failed_ticks_and_explains_the_first(robot: wbc.Robot) -> None:
    class Failing(HoldPosture):
        def step(self, estimate: wbc.Estimate) -> wbc.Command:
            c = super().step(estimate)
            return wbc.Command(
                c.tau,
                c.acceleration,
                {},
                c.q_target,
                c.v_target,
                wbc.Status.INFEASIBLE,
                "Infeasible: these constraints conflict — a and b",
            )

    report = wbc.run(Failing(robot), FrozenPlant(robot), 0.1)
    assert report.qp_failures == 50
    assert "a and b" in report.table()


def test_report_is_written_as_json(robot: wbc.Robot, tmp_path: object) -> None:
    report = wbc.run(HoldPosture(robot), FrozenPlant(robot), 0.1)
    path = tmp_path / "report.json"  # type: ignore[operator]
    report.save(path)
    stored = json.loads(path.read_text())
    assert stored["robot"] == "simple_humanoid"
    assert set(stored) == set(wbc.Report.__dataclass_fields__)


def test_garbage_collection_is_as_it_was_after_a_run(robot: wbc.Robot) -> None:
    wbc.run(HoldPosture(robot), FrozenPlant(robot), 0.05)
    assert gc.isenabled()


def test_duration_must_be_positive(robot: wbc.Robot) -> None:
    with pytest.raises(WbcError, match="duration = 0"):
        wbc.run(HoldPosture(robot), FrozenPlant(robot), 0.0)


def test_cruise_speed_of_a_short_walk_is_that_of_its_fastest_part() -> None:
    time = np.arange(0.0, 4.0, 0.1)
    x = 0.3 * np.clip(time - 1.0, 0.0, 2.0)  # 2 s at 0.3 m/s between two rests
    sway = 0.02 * np.sin(2.0 * np.pi * time / 1.6)
    _, mean, cruise = _distance_and_speeds(np.column_stack((x, sway)))
    assert cruise == pytest.approx(0.3, rel=0.1)
    assert mean < cruise


def test_distance_of_a_swaying_base_is_nearly_zero() -> None:
    rng = np.random.default_rng(0)
    distance, mean, cruise = _distance_and_speeds(1e-3 * rng.normal(size=(3000, 2)))
    assert distance < 0.01
    assert (mean, cruise) == (0.0, 0.0)


def test_repr_of_a_report_states_its_result() -> None:
    text = repr(
        wbc.run(HoldPosture(robot_ := wbc.load("simple_humanoid")), FrozenPlant(robot_), 0.1)
    )
    assert text.startswith("Report(simple_humanoid: survived 0.1 s; 0.00 m, 0 steps")


def test_diverged_physics_are_reported_with_the_figures_of_the_ticks_before(
    robot: wbc.Robot,
) -> None:
    with Mujoco(robot, noise=SensorNoise.none()) as plant:

        def disturb(now: float) -> None:
            if now > 0.1:
                plant.data.qvel[8] = 1e7

        report = wbc.run(HoldPosture(robot), plant, 1.0, before_tick=disturb)
    assert report.diverged
    assert not report.survived
    assert report.fell_at_s is None
    assert report.distance_m < 0.05
    assert report.duration_s == pytest.approx(0.1)
    assert "NO RESULT: the physics diverged at 0.104 s" in report.table()
