"""A biped with point feet steps, because it cannot stand still."""

from __future__ import annotations

import numpy as np
import pytest

import wbc
from wbc.contacts import PointContact

pytest.importorskip("mujoco")


@pytest.mark.parametrize("speed", [0.0, 0.3])
def test_bolt_steps_with_sensor_noise_and_the_estimator(speed: float) -> None:
    from wbc.sim import Mujoco

    robot = wbc.load("bolt")
    walker = wbc.Walker(robot)
    walker.velocity = (speed, 0.0, 0.0)
    assert walker.velocity == (speed, 0.0, 0.0)
    report = wbc.run(walker, Mujoco(robot, seed=1), 3.0)
    assert report.survived, report.fell_why
    assert report.steps >= 10
    assert report.qp_failures == 0
    # Without ankles the velocity is followed only roughly.
    assert speed == 0.0 or report.displacement_m[0] > 0.3 * speed * 3.0
    assert all(isinstance(contact, PointContact) for contact in walker.controller.contacts)


def test_the_estimator_lets_point_feet_turn_on_the_ground() -> None:
    from wbc.sim import Mujoco

    robot = wbc.load("bolt")
    walker, estimator = wbc.Walker(robot), wbc.Estimator(robot)
    walker.velocity = (0.4, 0.0, 0.0)
    errors = []
    with Mujoco(robot, seed=1) as plant:
        while plant.time < 2.5:
            estimate = estimator.update(plant.measure())
            plant.step(walker.step(estimate))
            errors.append(estimate.state.v[:3] - plant.ground_truth().v[:3])
    # Held for soles, the pitching feet would take a good part of the velocity away.
    assert np.abs(np.mean(errors[250:], axis=0)).max() < 0.02


def test_a_robot_with_soles_stands_still_without_a_velocity() -> None:
    walker = wbc.Walker(wbc.load("simple_humanoid"))
    walker.velocity = (0.0, 0.0, 0.0)
    assert walker.gait_state.at_rest
    assert not any(isinstance(contact, PointContact) for contact in walker.controller.contacts)
