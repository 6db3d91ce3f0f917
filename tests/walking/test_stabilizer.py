"""Stabilizer: step adjustment, bias of the CoM, and the order of a tick."""

from __future__ import annotations

import copy
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import wbc
from wbc.gait import (
    DcmPlanner,
    Feet,
    GaitCommand,
    GaitParameters,
    GaitState,
    GaitStateMachine,
    Phase,
    Placement,
    Velocity,
)
from wbc.sim import Mujoco, SensorNoise
from wbc.walking.feet import GroundReaction
from wbc.walking.ground_kinematics import CentroidalMotion
from wbc.walking.stabilizer import ComBiasEstimator, Stabilizer, footstep_adjustment

OMEGA, REACH = 3.4, (0.07, 0.04)
errors = st.floats(-0.15, 0.15)
times = st.floats(0.0, 0.6)


@given(errors, errors, times)
def test_footstep_shift_compensates_a_dcm_error_beyond_the_ankles(
    x: float, y: float, remaining: float
) -> None:
    shift = footstep_adjustment(complex(x, y), OMEGA, remaining, REACH)
    for error, reach, moved in ((x, REACH[0], shift.real), (y, REACH[1], shift.imag)):
        # The pendulum's error under the strongest push-back of the ankle, e' = ω (e − m).
        growth = math.exp(OMEGA * remaining)
        left = abs(error) * growth - reach * (growth - 1.0)
        assert abs(moved) == pytest.approx(max(left, 0.0), abs=1e-12)
        assert moved * error >= 0.0


@given(st.floats(0.05, 0.6))
def test_dcm_errors_within_the_ankles_reach_do_not_shift_the_footstep(remaining: float) -> None:
    caught = 0.99 * REACH[1] * (1.0 - math.exp(-OMEGA * remaining))
    assert footstep_adjustment(complex(0.0, caught), OMEGA, remaining, REACH) == 0j


@pytest.mark.parametrize("inertia", [0.0, 0.2])
def test_com_bias_is_estimated_from_the_force_of_the_ground(inertia: float) -> None:
    """The momentum is that of a pendulum, and with `inertia` more of legs that sway with it."""
    random, bias, dt, g = np.random.default_rng(2), ComBiasEstimator(9.81, 0.002), 0.002, 9.81
    sway, height = 2.0 * np.pi * 0.5, 0.9
    lever = (1.0 + inertia) * height / g  # s²
    for k in range(4000):
        com = 0.03 * np.exp(1j * sway * dt * k)
        cop = com * (1.0 + lever * sway**2) + 0.005 * random.standard_normal()
        estimate = com + (0.004 - 0.006j)
        momentum = 1j * sway * com * lever
        motion = CentroidalMotion(estimate, 1j * sway * com, height, 0.0, momentum, 0j)
        found = bias.update(motion, GroundReaction(cop, 1.0), 0.0)
    assert found == pytest.approx(0.004 - 0.006j, abs=7e-4)
    # While the robot steps the bias is kept, in the axes of the robot.
    turned = bias.update(motion, None, 0.5 * np.pi)
    assert turned == pytest.approx(1j * found, abs=1e-12)


def test_without_foot_sensors_the_com_bias_is_zero() -> None:
    bias, moved = ComBiasEstimator(9.81, 0.002), CentroidalMotion(0.1 + 0.1j, 0j, 0.8, 0.0, 0j, 0j)
    assert all(bias.update(moved, None, 0.3) == 0j for _ in range(10))


def test_landing_place_moves_in_the_tick_that_decides_it() -> None:
    robot = wbc.load("talos")
    gait, dt = GaitParameters.for_robot(robot), 0.002
    half = 0.5 * gait.step_width
    feet = Feet(Placement(complex(0.0, half), 0.0), Placement(complex(0.0, -half), 0.0))
    planner, stabilizer = DcmPlanner(), Stabilizer(robot, wbc.WalkerGains(), 0.002)
    machine, command = GaitStateMachine(gait, feet, planner), GaitCommand(Velocity(0.3))

    def tick(machine: GaitStateMachine, planner: DcmPlanner, push: complex) -> GaitState:
        state = machine.state
        machine.update(dt, feet, command, None)
        dcm = planner.reference(state).dcm + push
        stabilizer.observe(state, CentroidalMotion(dcm, 0j, 0.8, 0.0, 0j, 0j), None, 0.0)
        decided = stabilizer.update(state, lambda at: planner.reference(state, at))
        machine.move_swing(dt, decided.landing)
        return state

    while machine.state.swing is None or machine.state.swing.time < 0.3 * gait.single_support:
        tick(machine, planner, 0j)
    undisturbed = tick(*copy.deepcopy((machine, planner)), 0j)
    pushed = tick(machine, planner, 0.08 + 0j)
    moved = (pushed.landing.point - undisturbed.landing.point).real
    assert moved > 0.02
    assert pushed.swing.target == pushed.landing
    # The quintic towards the moved place: s''' = 60 Δ / T³ at its beginning.
    faster = (pushed.swing.motion.acceleration - undisturbed.swing.motion.acceleration)[0]
    assert faster == pytest.approx(60.0 * moved * dt / pushed.remaining**3, rel=0.05)


def test_the_dcm_has_the_angular_momentum_of_a_walking_robot_that_is_pushed_only() -> None:
    robot = wbc.load("talos")
    walker, momentum = wbc.Walker(robot), 0.01 - 0.02j
    state, stabilizer = walker.gait_state, walker.stabilizer
    motion = CentroidalMotion(0.1 + 0.1j, 0j, 0.8, 0.0, momentum, momentum)

    def dcm() -> complex:
        stabilizer.observe(state, motion, None, 0.0)
        return state.dcm

    state.phase = Phase.SWING
    assert dcm() == motion.point
    state.shortened = True
    assert dcm() == pytest.approx(motion.point + state.gait.omega * momentum, abs=1e-12)
    state.pushed_at_rest = True  # its trunk takes up the momentum, and gives it back
    assert dcm() == motion.point


def test_a_pendulum_with_angular_momentum_does_not_look_pushed() -> None:
    """A motion of the CoM that ZMP and pivot explain, with a trunk that turns besides."""
    robot, dt = wbc.load("talos"), 0.002
    walker = wbc.Walker(robot)
    state, stabilizer = walker.gait_state, walker.stabilizer
    state.phase, state.shortened = Phase.TRANSFER, True
    point, velocity = state.feet.middle + 0.01, 0j
    for _ in range(200):
        com = CentroidalMotion(point, velocity, 0.8, 0.0, 0.02 + 0j, 0.02 + 0j)
        stabilizer.observe(state, com, None, 0.0)
        decided = stabilizer.update(state, lambda at: walker.planner.reference(state, at))
        point += dt * velocity
        velocity += dt * decided.com_acceleration
    assert abs(state.disturbance) < 0.02


@pytest.mark.parametrize("name", ["talos", "g1"])
def test_accelerometer_bias_does_not_move_the_com_of_a_standing_robot(name: str) -> None:
    robot = wbc.load(name)
    walker = wbc.Walker(robot)
    noise = replace(SensorNoise.none(), accelerometer_bias=0.1)
    errors = []
    with Mujoco(robot, seed=2, noise=noise) as plant:

        def record(time: float) -> None:
            if time > 4.0:
                kin = wbc.Kinematics(robot, plant.ground_truth())
                soles = [kin.frame(sole.name).translation for sole in robot.soles]
                errors.append((kin.p_com - 0.5 * (soles[0] + soles[1]))[:2])

        report = wbc.run(walker, plant, 5.0, before_tick=record)
    assert report.survived
    assert np.linalg.norm(np.mean(errors, axis=0)) < 0.003
