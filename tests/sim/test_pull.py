"""A spring that pulls a link: where it leads, how strong it is, and that a copy goes on alike."""

import copy

import numpy as np
import pinocchio as pin
import pytest

import wbc
from wbc.errors import PlantError


@pytest.fixture(scope="module")
def robot():
    return wbc.load("simple_humanoid")


def test_a_pulled_robot_follows_the_spring_and_does_not_fall(robot):
    plant = wbc.sim.Mujoco(robot, ground_truth=True)
    walker = wbc.Walker(robot, dt=plant.dt)
    start = pin.centerOfMass(robot.model, robot.model.createData(), robot.q_nominal)[0]

    def before_tick(time):
        if round(time, 3) == 0.1:
            plant.pull(robot.torso, (0.0, 0.0, 0.0), (0.25, 0.0, robot.com_height))

    report = wbc.run(walker, plant, 1.0, before_tick=before_tick)
    end = pin.centerOfMass(robot.model, robot.model.createData(), plant.ground_truth().q)[0]
    assert report.survived
    assert start + 0.05 < end < start + 0.5


def test_the_force_of_a_pull_is_bounded_and_a_copy_goes_on_bit_identically(robot):
    plant = wbc.sim.Mujoco(robot)
    plant.pull(robot.torso, (0.0, 0.1, 0.2), (50.0, 0.0, 1.0))
    command = wbc.Command(
        *(np.zeros(n) for n in (robot.na, robot.nv)),
        {},
        np.zeros(robot.na),
        np.zeros(robot.na),
        wbc.Status.OK,
    )
    plant.step(command)
    force = plant.data.qfrc_applied[:3]
    assert np.linalg.norm(force) == pytest.approx(0.5 * robot.weight, rel=1e-6)
    other = copy.deepcopy(plant)
    for one in (plant, other):
        for _ in range(10):
            one.step(command)
    assert (plant.data.qpos == other.data.qpos).all()
    plant.release()
    plant.step(command)
    assert not plant.data.qfrc_applied.any()


@pytest.mark.parametrize("target", [(0.0, 1.0), (0.0, 0.0, np.nan)])
def test_a_pull_to_no_place_is_refused(robot, target):
    with pytest.raises(PlantError, match="three finite numbers"):
        wbc.sim.Mujoco(robot).pull(robot.torso, (0.0, 0.0, 0.0), target)
