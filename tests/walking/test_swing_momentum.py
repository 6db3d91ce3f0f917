"""The swing leg's angular momentum in the plan of the DCM."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import wbc
from wbc.gait import DcmReference, GaitState, Phase, Placement, SwingFoot
from wbc.geometry.planar import Feet
from wbc.sim import Mujoco
from wbc.walking.swing_momentum import SwingMomentum

DT = 0.002


def test_dcm_offset_obeys_the_pendulum_and_ends_with_the_swing() -> None:
    robot = wbc.load("g1")
    gait = wbc.GaitParameters.for_robot(robot)
    momentum, planner = SwingMomentum(robot), wbc.gait.DcmPlanner()
    landing = Placement(complex(0.0, -gait.step_width), 0.0)  # beside the other: the last step
    start = Placement(landing.point - (0.4 + 0.05j), 0.0)
    state = GaitState(gait, Feet(Placement(0j, 0.0), start), gait)
    planner.reset(state)
    state.phase, state.support, state.landing = Phase.SWING, "left", landing
    state.duration = gait.single_support
    state.swing = SwingFoot(start, landing, state.duration, 0.05, 0.05)
    offsets, rates = [], []
    for k in range(round(state.duration / DT)):
        state.time = k * DT
        reference = momentum.apply(DcmReference(0j, 0j, 0j), state, planner)
        offsets.append(reference.dcm)
        rates.append(reference.dcm_velocity)
        state.swing.advance(DT, landing)
    change = np.diff(offsets) / DT
    mean_rate = 0.5 * (np.array(rates[1:]) + np.array(rates[:-1]))
    assert np.abs(mean_rate).max() > 0.02
    moving = slice(round(0.06 * state.duration / DT), -1)  # after the foot has lifted
    assert change[moving] == pytest.approx(mean_rate[moving], abs=3e-3)
    assert abs(offsets[0]) > 0.01
    assert abs(offsets[-1]) < 1e-3  # the robot stands after this step


def test_offset_of_a_step_that_catches_a_push_is_that_of_the_motion_still_to_come() -> None:
    robot = wbc.load("g1")
    quick = wbc.GaitParameters.for_recovery(robot, wbc.GaitParameters.for_robot(robot))
    momentum, planner = SwingMomentum(robot), wbc.gait.DcmPlanner()
    start, landing = Placement(-0.2 - 0.2j, 0.0), Placement(0.1 - 0.1j, 0.0)
    state = GaitState(quick, Feet(Placement(0j, 0.0), start), quick)
    planner.reset(state)
    state.phase, state.support, state.shortened = Phase.SWING, "left", True
    state.landing, state.duration = landing, 0.2
    swing = state.swing = SwingFoot(start, landing, state.duration, 0.05, 0.05)
    ticks = round(state.duration / DT)
    expected, offsets, pivots = 0j, [], []
    for k in range(ticks):
        state.time = k * DT
        reference = momentum.apply(DcmReference(0j, 0j, 0j), state, planner)
        offsets.append(reference.dcm)
        pivots.append(reference.cmp_offset)
        swing.advance(DT, landing)
    # ξ_δ(t) = ω ∫ δ e^(−ω (s − t)) ds, summed backward.
    omega, largest = quick.omega, max(map(abs, offsets))
    assert largest > 0.05
    for k in reversed(range(ticks)):
        expected = expected * np.exp(-omega * DT) + omega * DT * pivots[k]
        assert abs(expected - offsets[k]) < 0.15 * largest


def test_momentum_ratio_is_that_of_the_model() -> None:
    # The rate of the angular momentum of two still arms, trunk and support leg is that of the leg.
    robot = wbc.load("talos")
    model, q = robot.model, robot.standing().q
    data = model.createData()
    leg = [int(i) for i in robot.legs[0]]
    v = np.zeros(model.nv)
    sole = robot.soles[0].frame_id
    J = pin.computeFrameJacobian(model, data, q, sole, pin.LOCAL_WORLD_ALIGNED)
    v[leg] = np.linalg.solve(J[:, leg], np.eye(6)[0])
    pin.ccrba(model, data, q, v)
    without_counter_motion = abs(data.hg.angular[1]) / robot.weight
    assert SwingMomentum(robot).ratio == pytest.approx(without_counter_motion, rel=0.35)


def test_fast_walk_on_small_feet_keeps_the_commanded_speed() -> None:
    robot = wbc.load("g1")
    walker, speed = wbc.Walker(robot), 0.43
    walker.velocity = (speed, 0.0, 0.0)
    marks = []
    with Mujoco(robot, seed=0) as plant:

        def mark(time: float) -> None:
            if walker.steps in (4, 6) and len(marks) < walker.steps // 2 - 1:
                marks.append((time, plant.ground_truth().q[0]))

        report = wbc.run(walker, plant, 6.5, before_tick=mark)
    assert report.survived
    (t0, x0), (t1, x1) = marks
    assert (x1 - x0) / (t1 - t0) == pytest.approx(speed, rel=0.05)
    assert report.dcm_error_rms_mm is not None
    assert report.dcm_error_rms_mm < 10.0
