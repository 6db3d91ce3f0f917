"""The tour: its waypoints, punches and arms, and a short one in physics."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from clitools import run
from policytools import write_standing_policy

import wbc
from wbc.robot.upper_body import UpperBody
from wbc.tasks import JointTorqueTask
from wbc.trials.policy import load_policy
from wbc.trials.tour import (
    ArmMotion,
    TourController,
    TourParameters,
    draw_direction,
    draw_tour,
    run_tour,
    summary,
)
from wbc.trials.tour.run import TourResult

_ANKLES = [(side, axis) for side in ("left", "right") for axis in ("pitch", "roll")]


@pytest.fixture(scope="module")
def g1():
    return wbc.load("g1")


def test_waypoints_are_uniform_on_the_disc_and_punches_grow_to_their_ceiling(g1):
    tours = [draw_tour(g1, seed) for seed in range(200)]
    places = np.array([w.point for tour in tours for w in tour.waypoints]) - 0.3
    assert np.abs(places).max() <= 1.0
    assert np.mean(np.abs(places) < math.sqrt(0.5)) == pytest.approx(0.5, abs=0.03)
    forces = np.array([[np.linalg.norm(p.force) for p in tour.punches] for tour in tours])
    ceilings = 500.0 * np.minimum(1 / 3 + 2 / 3 * np.arange(0.0, 90.0, 5.0) / 60.0, 1.0)
    assert (forces <= ceilings + 1e-9).all()
    assert (forces >= 0.5 * ceilings).all()
    np.testing.assert_allclose(forces.max(axis=0), ceilings, rtol=0.05)
    times = [punch.time for punch in tours[0].punches]
    np.testing.assert_allclose(times, 0.1 + 5.0 * np.arange(18))
    assert {punch.joint for tour in tours for punch in tour.punches} == set(g1.joint_names)


@pytest.mark.parametrize("elevation", [-0.5 * math.pi, math.radians(30.0)])
def test_directions_are_uniform_on_the_sphere_above_an_elevation(elevation):
    rng, lowest = np.random.default_rng(0), math.sin(elevation)
    directions = np.array([draw_direction(rng, elevation) for _ in range(4000)])
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0)
    assert directions[:, 2].min() >= lowest
    # A zone of the sphere has the area of its height (Archimedes).
    assert directions[:, 2].mean() == pytest.approx(0.5 * (lowest + 1.0), abs=0.02)
    assert np.abs(directions[:, :2].mean(axis=0)).max() < 0.05


def test_a_seed_is_one_tour(g1):
    assert str(draw_tour(g1, 3)) == str(draw_tour(g1, 3))
    assert str(draw_tour(g1, 3)) != str(draw_tour(g1, 4))


def test_the_robot_of_the_tour_is_g1_with_the_motors_of_the_benchmark(g1):
    robot = wbc.load("g1_tour")
    assert robot.joint_names == g1.joint_names
    assert robot.mass == pytest.approx(g1.mass)
    inertia = dict(zip(robot.joint_names, robot.model.armature[6:], strict=True))
    left = [value for name, value in inertia.items() if name.startswith("left")]
    right = [value for name, value in inertia.items() if name.startswith("right")]
    assert left == right
    small = inertia["left_elbow_joint"]
    assert inertia["left_ankle_roll_joint"] == inertia["waist_roll_joint"] == 2.0 * small
    # A motor alone, with its gains, oscillates at 10 Hz with damping ratio 2.
    arms = ArmMotion(robot, 0)
    rotor = robot.model.armature[6 + arms.joints]
    np.testing.assert_allclose(np.sqrt(arms.stiffness / rotor), 2.0 * math.pi * 10.0)
    np.testing.assert_allclose(0.5 * arms.damping / np.sqrt(arms.stiffness * rotor), 2.0)
    stronger = robot.tau_max - g1.tau_max
    ankles = [robot.joint_index(f"{side}_ankle_{axis}_joint") for side, axis in _ANKLES]
    np.testing.assert_allclose(stronger[ankles], 15.0)


def test_arms_move_as_mirror_images_within_their_limits_and_stay_in_front(g1):
    motion = ArmMotion(g1, 1)
    left, right = UpperBody.of(g1).both_arms()
    data = g1.model.createData()
    q = g1.q_nominal.copy()

    def hands():
        pin.forwardKinematics(g1.model, data, q)
        frames = (g1.frame_id(arm.hand) for arm in (left, right))
        return [pin.updateFramePlacement(g1.model, data, f).translation.copy() for f in frames]

    start = hands()[0][0]
    moved = 0.0
    for window in range(60):
        targets = motion.targets(0.5 * window)
        assert (targets >= g1.q_min[motion.joints] - 1e-12).all()
        assert (targets <= g1.q_max[motion.joints] + 1e-12).all()
        q[7 + motion.joints] = targets
        a, b = hands()
        np.testing.assert_allclose(a, b * (1.0, -1.0, 1.0), atol=1e-3)
        assert a[0] >= start - 1e-3
        moved = max(moved, float(np.abs(targets - g1.q_nominal[7 + motion.joints]).max()))
    assert moved > 0.3
    before, after = motion.targets(30.2), motion.targets(30.201)
    assert np.abs(after - before).max() < 0.01


def test_arm_torques_are_those_of_the_tour_and_the_walker_knows_them(g1):
    pytest.importorskip("mujoco")
    walker, motion = wbc.Walker(g1), ArmMotion(g1, 0)
    plant = wbc.sim.Mujoco(g1)
    controller = TourController(walker, motion, plant)
    state = g1.standing()
    controller.reset(state)
    command = controller.step(wbc.Estimate(state))
    target = motion.targets(0.0)
    torque = motion.stiffness * (target - state.q[7:][motion.joints])
    limit = g1.tau_max[motion.joints]
    np.testing.assert_allclose(command.tau[motion.joints], np.clip(torque, -limit, limit))
    # The equation of motion of the arms with these torques gives the accelerations it counts on.
    kin = wbc.Kinematics(g1, state)
    force = kin.mass_matrix @ command.acceleration + kin.bias_forces
    np.testing.assert_allclose(force[6 + motion.joints], torque, atol=1e-6)
    assert any(isinstance(task, JointTorqueTask) for task in walker.controller.tasks)


def test_the_limits_of_the_arms_do_not_contradict_what_somebody_else_does_with_them(g1):
    pytest.importorskip("mujoco")
    walker, motion = wbc.Walker(g1), ArmMotion(g1, 0)
    controller = TourController(walker, motion, wbc.sim.Mujoco(g1))
    state = g1.standing()
    stop = g1.q_max[motion.joints[3]]
    state.q[7 + motion.joints[3]], state.v[6 + motion.joints[3]] = stop - 0.001, 3.0
    controller.reset(state)
    command = controller.step(wbc.Estimate(state))
    assert command.status is wbc.Status.OK
    # Nothing brakes the arm but its motor and its weight, which the controller knows.
    kin = wbc.Kinematics(g1, state)
    force = kin.mass_matrix @ command.acceleration + kin.bias_forces
    np.testing.assert_allclose(force[6 + motion.joints], command.tau[motion.joints], atol=1e-6)


def test_a_policy_sees_arms_that_obey_it(g1, tmp_path):
    pytest.importorskip("onnxruntime")
    write_standing_policy(tmp_path, g1)
    policy, motion = load_policy(g1, folder=tmp_path), ArmMotion(g1, 0)
    seen = []
    step = policy.step
    policy.step = lambda estimate: seen.append(estimate.state) or step(estimate)
    controller = TourController(policy, motion, wbc.sim.Mujoco(g1))
    state = g1.standing()
    controller.reset(state)
    moved = wbc.State(state.q + np.where(np.arange(36) > 6, 0.1, 0.0), state.v + 0.2)
    controller.step(wbc.Estimate(moved))
    arms, legs = motion.joints, np.arange(15)
    np.testing.assert_allclose(seen[0].q[7:][arms], g1.q_nominal[7:][arms])
    assert not seen[0].v[6:][arms].any()
    np.testing.assert_array_equal(seen[0].q[7:][legs], moved.q[7:][legs])
    np.testing.assert_array_equal(seen[0].v[6:][legs], moved.v[6:][legs])


def test_a_short_tour_with_weak_punches_is_completed(g1):
    pytest.importorskip("mujoco")
    parameters = TourParameters(duration=3.0, waypoints=2, max_force=100.0, standing_time=0.2)
    tour = draw_tour(g1, 2, parameters)
    result = run_tour(g1, wbc.Walker(g1), tour)
    assert result.completed
    assert result.survived == 3.0
    assert result.last_punch == str(tour.punches[1])
    assert 0.0 < result.position_error < 2.0


def test_a_punch_that_nobody_survives_ends_the_tour(g1):
    pytest.importorskip("mujoco")
    parameters = TourParameters(duration=4.0, waypoints=1, standing_time=0.2)
    tour = draw_tour(g1, 0, parameters)
    blow = replace(tour.punches[0], joint="waist_pitch_joint", force=np.array([1500.0, 0.0, 0.0]))
    result = run_tour(g1, wbc.Walker(g1), replace(tour, punches=(blow,)))
    assert not result.completed
    assert 0.3 < result.survived < 3.0
    assert result.fall
    assert result.last_punch == "1500 N at waist_pitch_joint"


def test_the_ground_of_a_tour_is_as_slippery_as_its_parameters_say(g1):
    pytest.importorskip("mujoco")
    parameters = TourParameters(
        duration=3.0, waypoints=1, max_force=1.0, standing_time=0.2, friction=0.01
    )
    result = run_tour(g1, wbc.Walker(g1), draw_tour(g1, 0, parameters))
    assert not result.completed


def test_the_summary_is_the_mean_over_the_runs():
    results = [
        TourResult(0, True, 90.0, 0.1, 0.2, "", ""),
        TourResult(1, False, 30.0, 0.3, 0.4, "tilted", "300 N"),
    ]
    mean = summary("walker", results)
    assert (mean.completed, mean.survived) == (0.5, 60.0)
    assert (mean.position_error, mean.yaw_error) == pytest.approx((0.2, 0.3))


@pytest.mark.parametrize("name", ["walker", "policy"])
def test_the_command_prints_the_result_beside_the_published_ones(g1, tmp_path, name):
    pytest.importorskip("mujoco")
    pytest.importorskip("onnxruntime")
    write_standing_policy(tmp_path, g1)
    path = tmp_path / "tour.json"
    options = ["--seeds", "1", "--first-seed", "7", "--workers", "1", "--force", "9000"]
    options += ["--output", str(path)]
    options += ["--policy", str(tmp_path)] if name == "policy" else []
    code, out, err = run("trials", "tour", *options)
    assert code == 0, err
    rows = [line.split() for line in out.splitlines()]
    assert any(row[:3] == [name, "1", "0"] for row in rows)
    assert any(row[:3] == ["gr00t_wbc", "published", "80"] for row in rows)
    contents = json.loads(path.read_text())
    assert contents["parameters"]["max_force"] == 9000.0
    (tour,) = contents["runs"]
    assert (tour["seed"], tour["completed"]) == (7, False)
