"""The walker in physics, judged on the true state, fed only by sensors."""

from __future__ import annotations

import dataclasses
import math
import warnings

import numpy as np
import pinocchio as pin
import pytest
from cases import slow

import wbc
from wbc.errors import GaitError, StateError
from wbc.gait import Phase
from wbc.sim import Mujoco, Tiles


def walk(
    name: str,
    velocity: tuple[float, float, float],
    duration: float,
    stop: float,
    seed: int = 3,
    **plant: object,
) -> wbc.Report:
    robot = wbc.load(name)
    walker = wbc.Walker(robot)

    def command(time: float) -> None:
        walker.velocity = velocity if 0.2 <= time < stop else (0.0, 0.0, 0.0)

    with Mujoco(robot, seed=seed, **plant) as sim:
        return wbc.run(walker, sim, duration, before_tick=command)


def assert_clean(report: wbc.Report) -> None:
    assert report.survived, report.table()
    assert report.qp_failures == 0, report.explanation
    assert report.joint_limit_excess_rad <= 1e-3
    assert report.torque_excess_nm <= 0.0


@pytest.mark.parametrize(
    ("name", "velocity"),
    [
        ("talos", (0.4, 0.0, 0.0)),
        ("g1", (0.3, 0.0, 0.0)),
        ("simple_humanoid", (0.4, 0.0, 0.0)),
        slow("romeo", (0.2, 0.0, 0.0)),
        slow("talos", (-0.2, 0.0, 0.0)),
    ],
)
def test_robot_walks_straight_and_stops_on_its_feet(
    name: str, velocity: tuple[float, float, float]
) -> None:
    report = walk(name, velocity, duration=6.0, stop=3.8)
    assert_clean(report)
    asked = velocity[0] * 3.6
    assert 0.7 < report.displacement_m[0] / asked < 1.2
    assert abs(report.displacement_m[1]) < 0.15
    assert abs(report.turned_rad) < 0.1
    assert report.steps >= 5


def test_robot_walks_sideways_and_turns_while_walking() -> None:
    left = walk("simple_humanoid", (0.0, 0.1, 0.0), duration=5.5, stop=4.5)
    assert_clean(left)
    assert left.displacement_m[1] > 0.25
    assert abs(left.displacement_m[0]) < 0.1
    arc = walk("talos", (0.2, 0.0, -0.25), duration=5.0, stop=5.0)
    assert_clean(arc)
    assert arc.turned_rad < -0.8
    assert arc.displacement_m[0] > 0.3


def test_robot_walks_over_random_tiles() -> None:
    report = walk("talos", (0.3, 0.0, 0.0), 5.0, 5.0, terrain=Tiles(height=0.03, seed=1))
    assert_clean(report)
    assert report.displacement_m[0] > 0.7


def test_robot_survives_a_push_while_standing() -> None:
    robot = wbc.load("talos")
    walker = wbc.Walker(robot)
    with Mujoco(robot, seed=0) as plant:
        plant.schedule_push(0.5, (0.0, 0.2 * robot.mass, 0.0))
        report = wbc.run(walker, plant, 2.5)
    assert_clean(report)
    assert report.dcm_error_rms_mm is not None
    assert report.dcm_error_rms_mm > 5.0  # it was pushed


@pytest.mark.parametrize("again", [1.95, 2.1, 2.25])
def test_velocity_commanded_in_the_last_step_takes_effect_after_standing(again: float) -> None:
    robot = wbc.load("simple_humanoid")
    walker = wbc.Walker(robot)
    forward = (0.4 * walker.gait.max_velocity.forward, 0.0, 0.0)

    def on_and_off(time: float) -> None:
        wanted = (0.0, 0.0, 0.0) if time < 0.2 or 1.3 <= time < again else forward
        if walker.velocity != wanted:
            walker.velocity = wanted

    with Mujoco(robot, seed=1) as plant:
        report = wbc.run(walker, plant, 5.0, before_tick=on_and_off)
    assert report.survived
    assert report.steps >= 3
    assert report.dcm_error_rms_mm is not None
    assert report.dcm_error_rms_mm < 20.0


def test_robot_that_is_pushed_over_is_reported_as_fallen() -> None:
    robot = wbc.load("g1")
    with Mujoco(robot, seed=0) as plant:
        plant.schedule_push(0.3, (0.0, 3.0 * robot.mass, 0.0))
        report = wbc.run(wbc.Walker(robot), plant, 3.0)
    assert not report.survived
    assert 0.3 < report.fell_at_s < 3.0
    assert report.fell_why in report.table()


def test_walker_follows_given_footsteps() -> None:
    robot = wbc.load("talos")
    walker = wbc.Walker(robot)
    width = walker.gait.step_width
    steps = [
        wbc.Footstep(side, np.array([x, sign * width / 2, 0.0]), 0.0)
        for side, sign, x in (("right", -1, 0.2), ("left", 1, 0.45), ("right", -1, 0.45))
    ]
    with Mujoco(robot, seed=0) as plant:
        walker.follow(steps)
        report = wbc.run(walker, plant, 4.5)
        truth = wbc.Kinematics(robot, plant.ground_truth())
    assert_clean(report)
    assert walker.steps == 3
    assert walker.gait_state.phase is Phase.STAND
    for name, sign in (("left_sole", 1), ("right_sole", -1)):
        at = truth.frame(name).translation
        assert at[:2] == pytest.approx([0.45, sign * width / 2], abs=0.04)


@pytest.mark.parametrize("name", ["talos", "g1"])
def test_walking_torques_do_not_depend_on_position_and_heading(name: str) -> None:
    robot = wbc.load(name)
    move = pin.SE3(pin.utils.rotate("z", math.pi / 2), np.array([80.0, -60.0, 0.0]))
    here, there = wbc.Walker(robot), wbc.Walker(robot)
    with Mujoco(robot, seed=0, ground_truth=True) as plant:
        here.reset(plant.ground_truth())
        there.reset(_moved(robot, plant.ground_truth(), move))
        estimator, worst = wbc.GroundTruthEstimator(robot), 0.0
        while plant.time < 2.5:
            estimate = estimator.update(plant.measure())
            moved = dataclasses.replace(estimate, state=_moved(robot, estimate.state, move))
            velocity = (0.3, 0.05, 0.1) if plant.time > 0.2 else (0.0, 0.0, 0.0)
            here.velocity = there.velocity = velocity
            command = here.step(estimate)
            other = there.step(moved)
            worst = max(worst, float(abs(command.tau - other.tau).max()))
            plant.step(command)
    assert here.steps >= 2
    assert worst < 1e-6


def test_talos_walks_a_hundred_metres_away_facing_another_way() -> None:
    robot = wbc.load("talos")
    walker = wbc.Walker(robot)
    move = pin.SE3(pin.utils.rotate("z", math.pi / 2), np.array([80.0, -60.0, 0.0]))
    with Mujoco(robot, seed=0) as plant:
        plant.reset(_moved(robot, robot.standing(), move))

        def command(time: float) -> None:
            walker.velocity = (0.4, 0.0, 0.0)

        report = wbc.run(walker, plant, 4.0, before_tick=command)
    assert_clean(report)
    assert report.displacement_m[0] > 0.9
    assert abs(report.displacement_m[1]) < 0.15


def _moved(robot: wbc.Robot, state: wbc.State, move: pin.SE3) -> wbc.State:
    q = state.q.copy()
    base = move * pin.XYZQUATToSE3(q[:7])
    q[:7] = pin.SE3ToXYZQUAT(base)
    return wbc.State(q, state.v.copy())


def test_walking_without_foot_sensors_switches_phases_by_time() -> None:
    robot = wbc.load("simple_humanoid")
    walker = wbc.Walker(robot)
    with Mujoco(robot, ground_truth=True) as plant:
        walker.reset(plant.ground_truth())
        walker.velocity = (0.3, 0.0, 0.0)
        while plant.time < 3.0:
            state = plant.measure().ground_truth
            assert state is not None
            plant.step(walker.step(wbc.Estimate(state)))
        truth = plant.ground_truth()
    assert walker.steps >= 3
    assert truth.q[0] > 0.4
    assert truth.q[2] > 0.8 * robot.q_nominal[2]


def test_velocity_beyond_the_gait_is_clamped_with_a_warning() -> None:
    walker = wbc.Walker(wbc.load("talos"))
    with pytest.warns(wbc.VelocityClamped, match=r"talos.*clamped to"):
        walker.velocity = (3.0, 0.0, 0.0)
    assert walker.velocity == pytest.approx((walker.gait.max_velocity.forward, 0.0, 0.0), rel=1e-12)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        walker.velocity = (0.3, 0.0, 0.1)


def test_invalid_input_is_refused_with_name_and_value() -> None:
    robot = wbc.load("talos")
    walker = wbc.Walker(robot)
    state = robot.standing()
    with pytest.raises(GaitError, match="three numbers"):
        walker.velocity = (0.3, 0.0)
    with pytest.raises(GaitError, match="finite"):
        walker.velocity = (float("nan"), 0.0, 0.0)
    for bad in (0.3, None, "fast", ("a", "b", "c")):
        with pytest.raises(GaitError, match=r"velocity .* needs three numbers"):
            walker.velocity = bad
    broken = state.q.copy()
    broken[9] = np.nan
    with pytest.raises(StateError, match=r"q\[9\]"):
        walker.step(wbc.Estimate(wbc.State(broken, state.v)))
    with pytest.raises(GaitError, match="neither 'left' nor 'right'"):
        walker.follow([wbc.Footstep("middle", np.zeros(3), 0.0)])
    with pytest.raises(GaitError, match="alternate"):
        walker.follow([wbc.Footstep("left", np.zeros(3), 0.0)] * 2)


def test_telemetry_shows_the_present_step() -> None:
    robot = wbc.load("talos")
    walker = wbc.Walker(robot)
    seen = set()
    with Mujoco(robot, ground_truth=True) as plant:
        walker.reset(plant.ground_truth())
        estimator = wbc.GroundTruthEstimator(robot)
        walker.velocity = (0.3, 0.0, 0.0)
        while plant.time < 1.6:
            plant.step(walker.step(estimator.update(plant.measure())))
            telemetry = walker.telemetry
            seen.add(telemetry.phase)
            if telemetry.phase in ("left", "right"):
                plan = walker.contact_plan
                assert len(plan.footsteps) >= 2
                assert plan.footsteps[0].side != telemetry.phase
                landing = plan.footsteps[0].position
                assert plan.swing_path[-1][:2] == pytest.approx(landing[:2], abs=0.02)
                assert plan.support.shape == (4, 3)
    assert {"double", "left"} <= seen


def test_footsteps_beyond_reach_are_refused_with_the_step_named() -> None:
    walker = wbc.Walker(wbc.load("talos"))

    def step(side: str, x: float, y: float, yaw: float = 0.0) -> wbc.Footstep:
        return wbc.Footstep(side, np.array([x, y, 0.0]), yaw)

    good = [step("left", 0.2, 0.085), step("right", 0.4, -0.085)]
    walker.follow(good)
    refused = {
        r"footstep 0: the left foot would stand 5\.00 m ahead of the right foot": [
            step("left", 5.0, 0.085)
        ],
        r"footstep 2: the left foot would stand 5\.00 m ahead of footstep 1": [
            *good,
            step("left", 5.4, 0.085),
        ],
        r"footstep 1: .* -?0\.00 m beside it": [good[0], step("right", 0.2, 0.085)],
        r"footstep 0: position .* must be finite": [step("left", float("nan"), 0.085)],
        r"footstep 0: .* yaw nan": [step("left", 0.2, 0.085, float("nan"))],
        r"footstep 0: .* turned by 2\.00 rad": [step("left", 0.2, 0.085, 2.0)],
    }
    for message, footsteps in refused.items():
        with pytest.raises(GaitError, match=message):
            walker.follow(footsteps)


def test_repr_of_the_walker_states_phase_and_velocity() -> None:
    walker = wbc.Walker(wbc.load("talos"))
    walker.velocity = (0.3, 0.0, 0.0)
    assert repr(walker) == (
        "Walker(talos, DcmPlanner, phase STAND, support left, 0 steps, "
        "velocity (0.3 m/s, 0 m/s, 0 rad/s), dt 0.002 s)"
    )


def test_a_foot_whose_leg_lacks_joints_is_held_by_a_weight():
    lacking = wbc.load("g1", fixed_joints=("*_hip_yaw_joint", "*_ankle_roll_joint"))
    for robot, exact in ((wbc.load("g1"), True), (lacking, False)):
        walker = wbc.Walker(robot)
        assert walker.step(wbc.Estimate(robot.standing())).status is wbc.Status.OK
        support = walker.controller.contacts[0]
        assert (support.motion_weight is None) is exact
