"""Trials in physics: conditions, disturbances and forks."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pinocchio as pin
import pytest

import wbc
from wbc.trials import (
    Condition,
    ControllerSpec,
    ForceDisturbance,
    KickDisturbance,
    PushDisturbance,
    TrialError,
    replay_trial,
)
from wbc.trials.controllers import make_walker
from wbc.trials.disturbance import apply_disturbance
from wbc.trials.simulation import make_loop, simulate_run, simulate_trial
from wbc.trials.trial import Trial, UndisturbedRun

pytest.importorskip("mujoco")

RUN = UndisturbedRun("simple_humanoid", ControllerSpec(), (0.0, 0.0, 0.0), Condition(), 0)


@pytest.fixture(scope="module")
def robot() -> wbc.Robot:
    return wbc.load("simple_humanoid")


class UnpicklableWalker(wbc.Walker):
    """A walker that cannot be saved, as one in another process."""

    def __reduce__(self):
        raise TypeError("cannot pickle this")


def make_unpicklable(robot: wbc.Robot, dt: float) -> UnpicklableWalker:
    return UnpicklableWalker(robot, dt)


def broken(robot: wbc.Robot, dt: float) -> wbc.Walker:
    walker = make_walker(robot, dt)
    walker.step = None  # calling it raises a TypeError
    return walker


def test_a_controller_that_cannot_be_pickled_gives_the_same_results():
    spec = ControllerSpec("own", f"{__name__}:make_unpicklable")
    phase = Fraction(1, 3)
    outcomes = []
    for run in (RUN, replace(RUN, controller=spec)):
        result, (fork,) = simulate_run(run, (phase,))
        assert (fork.snapshot is None) == (run is not RUN)
        trial = Trial(run, phase, PushDisturbance(), 90.0, 0.2, 0.4)
        pushed = simulate_trial(fork, trial)
        same = {"key": "", "controller": ""}
        outcomes.append((replace(result, **same), replace(pushed, **same)))
    assert outcomes[0] == outcomes[1]


@pytest.mark.parametrize("size", [0.2, 2.0])
def test_a_replay_in_the_loop_of_the_library_ends_as_the_trial_did(size):
    phase = Fraction(1, 3)
    trial = Trial(RUN, phase, PushDisturbance(), 90.0, size, 1.0)
    _, (fork,) = simulate_run(RUN, (phase,))
    result = simulate_trial(fork, trial)
    report = replay_trial(trial)
    assert report.survived == result.survived == (size < 1.0)
    assert report.duration_s == pytest.approx(1.558 + result.duration_s, abs=0.012)
    if report.survived:
        assert report.torque_peak_ratio >= result.torque_peak
    else:
        assert 0.0 < result.falling_at_s < result.fell_at_s


def test_figures_of_an_undisturbed_walk_are_plausible():
    run, _ = simulate_run(replace(RUN, velocity=(0.2, 0.0, 0.0)), ())
    assert run.survived
    assert run.distance_m / run.duration_s == pytest.approx(0.2, rel=0.2)
    assert run.steps == pytest.approx(run.duration_s / 0.84, abs=1.5)
    assert 0.05 < run.cost_of_transport < 2.0
    assert 0.9 < run.landing_force_peak < 3.0
    assert run.velocity_error_rms_m_s < 0.05
    assert run.tilt_error_rms_rad < 0.02


def test_a_controller_that_raises_ends_its_own_trials_only():
    run = replace(RUN, controller=ControllerSpec("broken", f"{__name__}:broken"))
    result, (fork,) = simulate_run(run, (Fraction(0),))
    assert result.crashed
    assert not result.survived
    assert "TypeError" in result.reason
    pushed = simulate_trial(fork, Trial(run, Fraction(0), PushDisturbance(), 90.0, 0.2, 0.4))
    assert pushed.crashed
    assert "the undisturbed run ended: TypeError" in pushed.reason


@pytest.mark.parametrize(
    ("factory", "words"),
    [
        ("walkr", "must be 'walker', 'policy' or of the form"),
        ("no_such_module:make", "cannot import 'no_such_module'"),
        ("wbc.trials.controllers:make_walkr", "did you mean 'make_walker'"),
    ],
)
def test_a_factory_that_does_not_exist_is_refused(factory, words):
    with pytest.raises(TrialError, match=words):
        ControllerSpec(factory=factory).resolve()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"gait": {"single_suport": 0.2}}, "did you mean 'single_support'"),
        ({"gains": {"com_wait": 1.0}}, "did you mean 'com_weight'"),
        ({"gait": {"single_support": -1.0}}, "must be a positive number"),
    ],
)
def test_an_unknown_parameter_of_the_walker_is_refused(robot, options, words):
    with pytest.raises(TrialError, match=words):
        make_walker(robot, 0.002, **options)


def test_options_of_the_walker_are_used(robot):
    walker = make_walker(
        robot, 0.002, gait={"single_support": 0.4}, gains={"com_weight": 7.0}, recovery=False
    )
    assert walker.gait.single_support == 0.4
    assert walker.gains.com_weight == 7.0
    assert walker.recovery_gait is walker.gait


def test_a_velocity_beyond_the_gait_is_refused():
    with pytest.raises(TrialError, match=r"takes the velocity \(9, 0, 0\) on 'simple_humanoid' as"):
        make_loop(replace(RUN, velocity=(9.0, 0.0, 0.0)))


def test_the_nominal_condition_alters_nothing(robot):
    assert Condition().alter(robot) is robot


def test_mass_payload_and_torque_limits_alter_the_plant_alone(robot):
    heavy = Condition(mass=1.1, torque_limits=0.7).alter(robot)
    assert heavy.mass == pytest.approx(1.1 * robot.mass)
    np.testing.assert_allclose(heavy.tau_max, 0.7 * robot.tau_max)
    loop = make_loop(replace(RUN, condition=Condition(payload=5.0)))
    assert loop.plant.robot.mass == pytest.approx(robot.mass + 5.0)
    assert float(loop.plant.model.body_mass.sum()) == pytest.approx(robot.mass + 5.0)
    assert loop.controller.robot.mass == loop.robot.mass == pytest.approx(robot.mass)
    carried = Condition(payload=4.0, payload_on="hands").alter(robot)
    assert carried.mass == pytest.approx(robot.mass + 4.0)


@pytest.mark.parametrize("offset", [(0.02, 0.0, 0.0), (0.0, -0.02, 0.01)])
def test_the_centre_of_mass_is_off_by_what_the_condition_says(robot, offset):
    def com(one: wbc.Robot) -> np.ndarray:
        return pin.centerOfMass(one.model, one.model.createData(), robot.q_nominal)

    altered = Condition(com_offset=offset).alter(robot)
    np.testing.assert_allclose(com(altered) - com(robot), offset, atol=1e-12)


def test_joint_friction_and_damping_are_in_the_physics(robot):
    plant = Condition(joint_friction=0.02, joint_damping=0.01).make_plant(robot, 0.002, 0)
    for name, limit in zip(robot.joint_names, robot.tau_max, strict=True):
        dof = plant.model.joint(name).dofadr[0]
        assert plant.model.dof_frictionloss[dof] == pytest.approx(0.02 * limit)
        assert plant.model.dof_damping[dof] == pytest.approx(0.01 * limit)
    assert not plant.model.dof_frictionloss[:6].any()


def test_terrain_is_that_of_the_condition_and_the_seed(robot):
    def boxes(condition: Condition, seed: int) -> np.ndarray:
        return condition.make_plant(robot, 0.002, seed).terrain.boxes()

    assert not len(boxes(Condition(), 0))
    tiles = Condition(tiles=0.02)
    np.testing.assert_array_equal(boxes(tiles, 1), boxes(tiles, 1))
    assert (boxes(tiles, 1) != boxes(tiles, 2)).any()
    assert abs(boxes(Condition(slope=5.0), 0)[:, 7]).max() == pytest.approx(np.radians(5.0))
    slippery = Condition(patch_friction=0.3).make_plant(robot, 0.002, 0)
    assert slippery.model.geom_friction[:, 0].min() == pytest.approx(0.3)
    with pytest.raises(TrialError, match="tiles and slope exclude each other"):
        Condition(tiles=0.02, slope=5.0)


def test_soft_ground_and_late_sensors_are_in_the_physics(robot):
    hard, soft = (Condition(ground_sink=depth).make_plant(robot, 0.002, 0) for depth in (0, 0.005))
    assert (hard.model.geom_solref != soft.model.geom_solref).any()
    command = make_loop(RUN).tick()[1]
    readings = []
    for age in (0.0, 0.004):
        plant = Condition(noise=0.0, sensor_latency=age).make_plant(robot, 0.002, 0)
        plant.push([0.0, 20.0, 0.0])
        readings.append([])
        for _ in range(6):
            plant.step(command)
            readings[-1].append(plant.measure().joint_velocity)
    now, late = readings
    np.testing.assert_array_equal(late[2:], now[:-2])


@pytest.mark.parametrize("degrees", [0.0, 90.0, 215.0])
def test_directions_are_those_of_the_heading_and_a_size_means_the_same_on_every_robot(degrees):
    loop = make_loop(RUN)
    state = loop.plant.ground_truth()
    yaw = 0.7
    state.q[3:7] = pin.Quaternion(pin.rpy.rpyToMatrix(0.0, 0.0, yaw)).coeffs()
    loop.plant.reset(state)
    mass = loop.robot.mass
    angle = np.radians(degrees) + yaw
    expected = np.array([np.cos(angle), np.sin(angle), 0.0])
    push = PushDisturbance(duration=0.1)
    apply_disturbance(push, loop.plant, degrees, 0.3, mass)
    np.testing.assert_allclose(loop.plant.push_force * 0.1, 0.3 * mass * expected, atol=1e-9)
    loop.plant.reset(state)
    apply_disturbance(ForceDisturbance(), loop.plant, degrees, 0.3, mass)
    np.testing.assert_allclose(loop.plant.push_force, 0.3 * mass * expected, atol=1e-9)
    loop.plant.reset(state)
    apply_disturbance(KickDisturbance(), loop.plant, degrees, 0.3, mass)
    velocity = loop.plant.ground_truth().v
    rotation = pin.rpy.rpyToMatrix(0.0, 0.0, yaw)
    np.testing.assert_allclose(rotation @ velocity[:3], 0.3 * expected, atol=1e-9)
    assert not velocity[3:].any()


def test_contact_by_time_tells_the_controller_nothing_of_the_feet(robot):
    condition = Condition(contact="time", state="exact")
    plant = condition.make_plant(robot, 0.002, 0)
    estimator = condition.make_estimator(robot, 0.002)
    estimator.reset(plant.ground_truth())
    estimate = estimator.update(plant.measure())
    assert estimate.loads is None
    assert not estimate.contacts
    assert not estimate.foot_wrenches
    np.testing.assert_array_equal(estimate.state.q, plant.ground_truth().q)
