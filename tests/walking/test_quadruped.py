"""A quadruped trots, with sensor noise and the estimator, within its joints' limits."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from cases import slow

import wbc
from wbc.errors import GaitError
from wbc.gait import PACE, TROT, QuadrupedGait
from wbc.walking.quadruped.footholds import dcm_offsets, group_centers

pytest.importorskip("mujoco")


@pytest.fixture(scope="module")
def solo() -> wbc.Robot:
    joints = wbc.load("solo12").joint_names
    return wbc.load("solo12", effort_limits=dict.fromkeys(joints, 2.7), armature=5e-4)


@pytest.mark.parametrize("groups", [TROT, PACE])
@pytest.mark.parametrize("velocity", [0j, 0.5 + 0j, 0.2 - 0.3j])
def test_steady_steps_repeat_the_offset_of_the_dcm(solo, groups, velocity) -> None:
    gait = QuadrupedGait.for_robot(solo, groups)
    places = {"front_left": 0.2 + 0.1j, "front_right": 0.2 - 0.1j}
    places |= {"hind_left": -0.2 + 0.1j, "hind_right": -0.2 - 0.1j}
    centers = group_centers(gait, places)
    offsets = dcm_offsets(gait, centers, velocity)
    for k in range(2):
        following = (k + 1) % 2
        way = velocity * gait.step_duration + centers[following] - centers[k]
        end = offsets[k] * np.exp(gait.omega * gait.step_duration)
        assert end == pytest.approx(way + offsets[following], abs=1e-12)


@pytest.mark.parametrize(
    ("name", "velocity", "push"),
    [
        ("solo12", (0.28, 0.0, 0.0), (0.0, 0.5)),
        ("solo12", (0.0, 0.1, 0.5), (-0.5, 0.0)),
        ("go2", (0.3, 0.0, 0.3), (0.0, -0.5)),
    ],
)
def test_a_quadruped_trots_where_it_is_told_and_takes_a_push(solo, name, velocity, push) -> None:
    robot = solo if name == "solo12" else wbc.load(name)
    walker = wbc.QuadrupedWalker(robot)
    walker.velocity = velocity
    with wbc.sim.Mujoco(robot, seed=1) as plant:
        plant.schedule_push(1.0, (robot.mass * push[0], robot.mass * push[1], 0.0))
        report = wbc.run(walker, plant, 2.0)
    assert report.survived, report.fell_why
    assert report.steps >= 6
    assert report.qp_failures == 0
    assert walker.heading == pytest.approx(2.0 * velocity[2], abs=0.4)
    turned = np.exp(0.5j * walker.heading)
    way = complex(*report.displacement_m) / turned - 0.2 * complex(*push)
    assert (way * np.conj(complex(*velocity[:2]))).real > 0.2 * abs(complex(*velocity[:2])) ** 2


def test_a_quadruped_stands_still_and_steps_when_it_is_pushed(solo) -> None:
    walker = wbc.QuadrupedWalker(solo)
    with wbc.sim.Mujoco(solo) as plant:
        report = wbc.run(walker, plant, 0.5)
        assert report.steps == 0
        assert np.hypot(*report.displacement_m) < 0.005
        plant.push((0.0, 1.0 * solo.mass, 0.0))
        report = wbc.run(walker, plant, 1.5)
    assert report.survived, report.fell_why
    assert report.steps >= 2


def test_an_estimator_of_four_point_feet_follows_a_trot(solo) -> None:
    walker, estimator = wbc.QuadrupedWalker(solo), wbc.Estimator(solo)
    walker.velocity = (0.28, 0.0, 0.0)
    errors = []
    with wbc.sim.Mujoco(solo, seed=2) as plant:
        for _ in range(750):
            estimate = estimator.update(plant.measure())
            plant.step(walker.step(estimate))
            truth = plant.ground_truth()
            if plant.time > 0.5:
                errors.append(estimate.state.v[:3] - truth.v[:3])
    rms = np.sqrt(np.mean(np.square(errors)))
    assert rms < 0.06, rms


def test_a_copy_of_a_trot_goes_on_bit_identically(solo) -> None:
    walker, estimator = wbc.QuadrupedWalker(solo), wbc.Estimator(solo)
    walker.velocity = (0.2, 0.0, 0.3)
    plant = wbc.sim.Mujoco(solo, seed=3)

    def run(parts, ticks: int) -> np.ndarray:
        walker, estimator, plant = parts
        for _ in range(ticks):
            command = walker.step(estimator.update(plant.measure()))
            plant.step(command)
        return command.tau

    parts = (walker, estimator, plant)
    run(parts, 130)
    copied, pickled = copy.deepcopy(parts), pickle.loads(pickle.dumps(parts))
    expected = run(parts, 60)
    np.testing.assert_array_equal(run(copied, 60), expected)
    np.testing.assert_array_equal(run(pickled, 60), expected)


def test_a_velocity_beyond_the_gait_is_clamped_with_a_warning(solo) -> None:
    walker = wbc.QuadrupedWalker(solo)
    with pytest.warns(wbc.VelocityClamped, match="solo"):
        walker.velocity = (9.0, 0.0, 0.0)
    assert walker.velocity[0] == pytest.approx(walker.gait.max_velocity.forward)
    with pytest.raises(GaitError, match="finite"):
        walker.velocity = (float("nan"), 0.0, 0.0)


def test_a_gait_names_the_feet_that_it_lacks(solo) -> None:
    with pytest.raises(GaitError, match="whose feet are front_left, front_right"):
        QuadrupedGait.for_robot(solo, (("left",), ("right",)))


def test_a_quadruped_that_cannot_be_caught_is_said_to_fall_and_yields(solo) -> None:
    walker, said = wbc.QuadrupedWalker(solo), []
    with wbc.sim.Mujoco(solo, seed=1) as plant:
        plant.schedule_push(0.1, (0.0, 2.5 * solo.mass, 0.0))
        report = wbc.run(walker, plant, 1.5, on_falling=said.append)
    assert report.fell_at_s is not None
    assert report.falling_at_s < report.fell_at_s
    assert said[0].startswith("falling: the DCM is")
    assert walker.falling_why
    estimator = wbc.Estimator(solo)
    with wbc.sim.Mujoco(solo) as upright:  # standing again does not end it
        command = walker.step(estimator.update(upright.measure()))
    assert (np.abs(command.tau) <= 0.5 * solo.tau_max + 1e-9).all()
    assert not len(walker.contact_plan.support)
    walker.reset(solo.standing())
    assert not walker.falling_why


@pytest.mark.parametrize(
    ("name", "push"),
    [("laikago", (0.0, -0.82)), slow("anymal_b_simple_description/robots/anymal", (0.0, 0.85))],
)
def test_legs_at_their_torque_limits_give_way_instead_of_leaving_no_solution(name, push) -> None:
    robot = wbc.load(name)
    walker = wbc.QuadrupedWalker(robot)
    with wbc.sim.Mujoco(robot, seed=0) as plant:
        plant.schedule_push(0.2, (robot.mass * push[0], robot.mass * push[1], 0.0))
        report = wbc.run(walker, plant, 1.2)
    assert report.survived, report.fell_why
    assert report.torque_peak_ratio > 0.99
    assert report.qp_failures == 0
