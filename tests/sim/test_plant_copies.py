"""A copied plant goes on as the original does, bit by bit."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from simtools import JointPDController, robot

from wbc.sim import Mujoco, Tiles

pytest.importorskip("mujoco")


def trace(plant: Mujoco, hold: JointPDController, ticks: int) -> np.ndarray:
    """(ticks, n) everything that is measured, and the exact state."""
    rows = []
    for _ in range(ticks):
        m = plant.measure()
        truth = plant.ground_truth()
        sensors = (m.joint_position, m.joint_velocity, m.gyro, m.accelerometer)
        rows.append(np.concatenate([*sensors, *m.foot_wrenches.values(), truth.q, truth.v]))
        plant.step(hold(m))
    return np.array(rows)


@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda p: pickle.loads(pickle.dumps(p))])
@pytest.mark.parametrize("terrain", [None, Tiles(height=0.01, size=0.3, clearing=0.0)])
def test_copied_plant_continues_bit_identically_with_noise_pushes_and_latency(duplicate, terrain):
    r = robot()
    hold = JointPDController(r)
    with Mujoco(r, terrain=terrain, seed=5, latency=0.003) as plant:
        plant.schedule_push(0.05, [30.0, 10.0, 0.0], duration=0.05)
        plant.schedule_push(0.12, [0.0, -20.0, 0.0], duration=0.03)
        for ticks in (0, 13, 20, 25):  # before, during and between the pushes
            trace(plant, hold, ticks)
            other = duplicate(plant)
            assert other.time == plant.time
            expected = trace(copy.deepcopy(plant), hold, 40)
            np.testing.assert_array_equal(trace(other, hold, 40), expected)
        other = duplicate(plant)
        np.testing.assert_array_equal(trace(other, hold, 20), trace(plant, hold, 20))


def test_copied_plant_is_independent_and_resets_like_the_original():
    r = robot()
    hold = JointPDController(r)
    with Mujoco(r, seed=5) as plant:
        first = trace(plant, hold, 20)
        other = copy.deepcopy(plant)
        plant.push([60.0, 0.0, 0.0])
        trace(plant, hold, 20)
        assert not other.push_force.any()
        assert other.time == pytest.approx(0.04)
        other.reset()
        np.testing.assert_array_equal(trace(other, hold, 20), first)
