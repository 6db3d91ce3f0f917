"""A fall is foreseen, announced and soft."""

from __future__ import annotations

import pickle

import numpy as np
import pinocchio as pin
import pytest
from simtools import robot

import wbc
from wbc.geometry.planar import Placement
from wbc.kinematics import Kinematics
from wbc.log import FlightRecorder, Log, LoggedRun
from wbc.motions import MotionPlayer
from wbc.motions.squat import Squat
from wbc.robot.fall import fall_reason
from wbc.sim import Mujoco
from wbc.state import State
from wbc.walking.falling import FallController, FallDetector
from wbc.walking.ground_kinematics import GroundKinematics

pytest.importorskip("mujoco")

DT = 0.002
FEET = (Placement(0.1j, 0.0), Placement(-0.1j, 0.0))


Tilt = tuple[float, float]


def leaning(r: wbc.Robot, tilt: float, rate: float, axis: np.ndarray) -> Tilt:
    """Tilt of the nominal posture, turned about a horizontal axis and turning on at a rate."""
    state = r.standing()
    turn = pin.exp3(tilt * axis)
    base = turn @ pin.XYZQUATToSE3(state.q[:7]).rotation
    state.q[3:7] = pin.Quaternion(base).coeffs()
    state.v[3:6] = base.T @ (rate * axis)
    ground = GroundKinematics(r, Kinematics(r, state))
    ground.read()
    return ground.tilt


def ticks_until_alarm(
    detector: FallDetector, tilt: Tilt, dcm: complex, height: float, base: tuple[float, float]
) -> int:
    """Number of ticks; 0: no alarm within 100."""
    detector.reset()
    for tick in range(1, 101):
        if detector.update(tilt, dcm, height, base, FEET):
            return tick
    return 0


@pytest.mark.parametrize("name", ["g1", "icub"])  # icub's base has its x axis backwards
@pytest.mark.parametrize("direction", [0.0, 2.0, 4.0])
def test_an_alarm_needs_the_sum_of_distance_tilt_rate_and_lost_height_for_30_ms(name, direction):
    r = robot(name)
    detector, h = FallDetector(r, DT), r.com_height
    axis = np.array([np.cos(direction), np.sin(direction), 0.0])
    edge = max(s.half_length for s in r.soles)

    assert leaning(r, 0.3, -0.5, axis) == pytest.approx((0.3, -0.5))

    def alarm(distance=0.0, tilt=0.0, rate=0.0, lost=0.0) -> int:
        dcm = complex(edge + distance * h, 0.0)
        leans, base = leaning(r, tilt, rate, axis), (r.q_nominal[2], 0.0)
        return ticks_until_alarm(detector, leans, dcm, (1.0 - lost) * h, base)

    assert alarm() == 0
    assert alarm(distance=1.6) == 0
    assert alarm(distance=1.7) == 15
    assert alarm(distance=0.7, tilt=0.5, rate=1.0, lost=0.3) == 0
    assert alarm(distance=0.7, tilt=0.5, rate=1.0, lost=0.4) == 15
    assert alarm(distance=0.7, tilt=0.5, rate=2.0, lost=0.3) == 15
    # A robot that rises again is given the time to.
    assert alarm(distance=0.7, tilt=0.5, rate=-9.0, lost=0.35) == 0


@pytest.mark.parametrize("name", ["g1", "icub"])
def test_a_robot_that_topples_or_sinks_over_its_feet_is_about_to_fall(name):
    r = robot(name)
    detector, standing = FallDetector(r, DT), float(r.q_nominal[2])

    def alarm(tilt=0.0, rate=0.0, height=1.0, rising=0.0) -> int:
        base = (height * standing, rising * standing)
        return ticks_until_alarm(detector, (tilt, rate), 0j, r.com_height, base)

    assert alarm(tilt=1.15, rate=2.0) == 0
    assert alarm(tilt=1.17, rate=2.0) == 5
    assert alarm(tilt=1.21, rate=-9.0) == 0
    assert alarm(height=0.67, rising=-2.0) == 0
    assert alarm(height=0.65, rising=-2.0) == 5
    assert alarm(height=0.61, rising=9.0) == 0  # from a deep crouch it rises again
    assert alarm(height=0.61, rising=-0.2) == 0


def test_a_moment_beyond_the_threshold_is_no_alarm():
    r = robot("g1")
    h, standing = r.com_height, (float(r.q_nominal[2]), 0.0)
    far, toppling = FallDetector(r, DT), FallDetector(r, DT)
    for tick in range(200):
        dcm = complex(0.0 if tick % 14 == 0 else 3.0, 0.0)
        assert not far.update((0.0, 0.0), dcm, h, standing, FEET)
        tilt = 0.0 if tick % 4 == 0 else 1.0
        assert not toppling.update((tilt, 0.0), 0j, h, standing, FEET)


def test_fall_controller_takes_energy_out_of_the_joints_and_bends_the_knees():
    r = robot("talos")
    knees = [r.joint_index(f"leg_{side}_4_joint") for side in ("left", "right")]
    controller = FallController(r, DT, knees)
    random = np.random.default_rng(0)
    for _ in range(20):
        state = State(r.standing().q, random.standard_normal(r.nv) * 5.0)
        command = controller.command(state)
        assert np.all(np.abs(command.tau) <= 0.5 * r.tau_max + 1e-12)
        power = command.tau * state.v[6:]
        assert np.all(np.delete(power, knees) <= 0.0)
    at_rest = controller.command(r.standing()).tau
    assert np.all(at_rest[knees] > 0.0)  # Talos bends its knees this way
    assert not np.delete(at_rest, knees).any()


def test_a_robot_that_lies_keeps_its_posture_until_its_body_turns_again():
    r = robot("talos")
    knee = r.joint_index("leg_left_4_joint")
    arm = r.joint_index("arm_left_1_joint")
    controller, lying = FallController(r, DT, [knee]), r.standing()
    for _ in range(149):
        assert controller.command(lying).tau[arm] == 0.0
    sunk = State(lying.q.copy(), lying.v)
    for _ in range(10):
        controller.command(lying)
    sunk.q[7:] -= 0.1
    assert controller.command(sunk).tau[arm] > 0.0
    # The knee is drawn to the middle of its range all the time, by more if it is farther away.
    assert controller.command(sunk).tau[knee] > controller.command(lying).tau[knee] > 0.0
    turning = State(sunk.q, sunk.v.copy())
    turning.v[4] = 1.0
    for _ in range(100):
        assert controller.command(turning).tau[arm] == 0.0
    assert controller.command(sunk).tau[arm] == 0.0


def test_a_fall_is_announced_before_it_and_the_robot_yields_until_its_reset():
    r = robot("g1")
    walker, plant, said = wbc.Walker(r), Mujoco(r, seed=2), []
    phases, torques = [], []

    class Watch:
        def begin(self, controller, plant) -> None: ...

        def observe(self, tick) -> None:
            phases.append(tick.telemetry.phase)
            if phases[-1] == "falling":
                torques.append(np.abs(tick.command.tau) / r.tau_max)

        def end(self, report) -> None: ...

    plant.schedule_push(0.2, [0.0, 1.5 * r.mass, 0.0])
    report = wbc.run(walker, plant, 3.0, observers=[Watch()], on_falling=said.append)
    assert report.fell_at_s is not None
    assert report.fell_at_s - report.falling_at_s > 0.05
    assert "foreseen" in report.table()
    assert len(said) == 1
    assert said[0].startswith("falling: the DCM is")
    first = phases.index("falling")
    assert set(phases[first:]) == {"falling"}
    assert np.max(torques) <= 0.5 + 1e-9
    assert walker.falling_why
    # Standing again does not end it, only a reset does; a copy falls on in the same way.
    standing = wbc.GroundTruthEstimator(r)
    plant.reset()
    upright = Mujoco(r, ground_truth=True)
    estimate = standing.update(upright.measure())
    other = pickle.loads(pickle.dumps(walker))
    np.testing.assert_array_equal(walker.step(estimate).tau, other.step(estimate).tau)
    assert walker.telemetry.phase == "falling"
    assert not len(walker.contact_plan.support)
    walker.reset(r.standing())
    walker.step(estimate)
    assert walker.telemetry.phase == "stand"
    assert not walker.falling_why


def test_a_falling_robot_gives_up_its_motion_and_the_log_has_the_phase(tmp_path):
    r = robot("simple_humanoid")
    player, file = MotionPlayer(r, motions=[Squat()]), tmp_path / "fall.mcap"
    plant = Mujoco(r, seed=2)
    plant.schedule_push(0.5, [2.3 * r.mass, 0.0, 0.0])
    with FlightRecorder(file, r) as recorder:
        report = wbc.run(player, plant, 3.0, observers=[recorder], on_falling=lambda text: None)
    assert report.falling_at_s is not None
    assert player.aborted_motions == ("squat",)
    assert player.idle
    assert LoggedRun(Log(file)).at(report.fell_at_s).telemetry.phase == "falling"


def test_a_robot_in_its_fall_comes_to_rest_without_flailing():
    r = robot("talos")
    plant, estimator, walker = Mujoco(r, seed=1), wbc.Estimator(r), wbc.Walker(r)
    plant.schedule_push(0.1, [-1.2 * r.mass, 0.0, 0.0])
    expected, speeds = None, []
    for _ in range(2000):
        command = walker.step(estimator.update(plant.measure(), acceleration=expected))
        expected = command.acceleration
        plant.step(command)
        speeds.append(np.abs(plant.ground_truth().v[6:]).max())
    assert walker.falling_why
    assert fall_reason(r, plant.ground_truth())
    assert max(speeds[-50:]) < 0.1
