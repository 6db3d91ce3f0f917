"""Soft ground, slippery ground, sensors that are late or stand still."""

from __future__ import annotations

import copy
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
import pytest
from simtools import JointPDController, robot, run

from wbc.errors import PlantError
from wbc.sim import Mujoco, SensorNoise, SlipperyPatch

pytest.importorskip("mujoco")

QUIET = SensorNoise.none()


@pytest.mark.parametrize("name", ["talos", "g1"])
@pytest.mark.parametrize("sink", [1e-3, 2e-3])
def test_a_standing_robot_sinks_into_soft_ground_by_the_stated_depth(name, sink):
    r = robot(name)
    with Mujoco(r, noise=QUIET, ground_sink=sink) as plant:
        run(plant, 1.0, JointPDController(r))
        data = r.model.createData()
        pin.framesForwardKinematics(r.model, data, plant.ground_truth().q)
        depths = [-data.oMf[sole.frame_id].translation[2] for sole in r.soles]
        np.testing.assert_allclose(depths, sink, rtol=0.2)
        carried = sum(force for _, force in plant.contacts())
        np.testing.assert_allclose(carried, [0.0, 0.0, r.weight], atol=0.02 * r.weight)


@dataclass(frozen=True)
class Slab:
    """A slab below the robot's start, 1 mm above the floor."""

    friction: float

    def boxes(self) -> np.ndarray:
        return np.array([[0.0, 0.0, -0.049, 3.0, 3.0, 0.05]])


def test_soles_slip_on_a_terrain_of_low_friction():
    r = robot("simple_humanoid")
    start = r.standing()
    start.q[2] += 1e-3
    ways = []
    for friction in (0.8, 0.1):
        with Mujoco(r, terrain=Slab(friction), noise=QUIET) as plant:
            plant.reset(start)
            hold = JointPDController(r)
            run(plant, 0.2, hold)
            # At the hip a push does not topple it before it slips.
            plant.push([0.0, 0.25 * r.weight * 0.2, 0.0], duration=0.2, frame=r.base)
            run(plant, 0.1, hold)
            total = sum(force for _, force in plant.contacts())
            if friction == 0.1:
                assert np.hypot(*total[:2]) == pytest.approx(0.1 * total[2], rel=0.02)
            feet = []
            for _ in range(2):
                data = r.model.createData()
                pin.framesForwardKinematics(r.model, data, plant.ground_truth().q)
                feet.append(data.oMf[r.soles[0].frame_id].translation[1])
                run(plant, 0.1, hold)
            ways.append(abs(feet[1] - feet[0]))
    assert ways[0] < 1e-3
    assert ways[1] > 5e-3


def test_slippery_patch_begins_at_its_distance_and_refuses_impossible_sizes():
    x, y, z, half_length, half_width, half_height = SlipperyPatch(0.2, 0.5, 2.0, 4.0).boxes()[0]
    assert x - half_length == pytest.approx(0.5)
    assert (y, half_width) == (0.0, 2.0)
    assert 0.0 < z + half_height < 2e-3
    with pytest.raises(PlantError, match="friction"):
        SlipperyPatch(friction=-0.1)
    with pytest.raises(PlantError, match="width"):
        SlipperyPatch(width=0.0)


def test_late_sensors_deliver_the_readings_of_earlier_ticks():
    r = robot("simple_humanoid")
    with Mujoco(r, noise=QUIET) as now, Mujoco(r, noise=QUIET, sensor_latency=0.006) as late:
        exact, delayed = [], []
        for plant, readings in ((now, exact), (late, delayed)):
            plant.push([0.0, 20.0, 0.0])
            hold, still = JointPDController(r), plant.measure()
            for _ in range(30):
                m = plant.measure()
                forces = np.concatenate(list(m.foot_wrenches.values()))
                readings.append(np.concatenate([m.joint_velocity, m.gyro, forces]))
                plant.step(hold(still))  # the same command for both
        np.testing.assert_array_equal(delayed[3:], exact[:-3])
        assert not np.array_equal(delayed, exact)
    with pytest.raises(PlantError, match="sensor_latency"):
        Mujoco(r, sensor_latency=0.003)


def test_frozen_sensors_repeat_one_measurement_also_in_a_copy():
    r = robot("simple_humanoid")
    hold = JointPDController(r)
    with Mujoco(r, seed=3) as plant:
        plant.schedule_sensor_freeze(0.01, 0.006)

        def gyro(plant: Mujoco) -> np.ndarray:
            m = plant.measure()
            plant.step(hold(m))
            return m.gyro

        readings = [gyro(plant) for _ in range(6)]
        other = copy.deepcopy(plant)
        readings += [gyro(plant) for _ in range(6)]
        same = [k for k in range(1, 12) if np.array_equal(readings[k], readings[k - 1])]
        assert same == [5, 6, 7]
        np.testing.assert_array_equal([gyro(other) for _ in range(6)], readings[6:])
        with pytest.raises(PlantError, match="already"):
            plant.schedule_sensor_freeze(0.0, 0.01)
        with pytest.raises(PlantError, match="positive"):
            plant.schedule_sensor_freeze(1.0, 0.0)
