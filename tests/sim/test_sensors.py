"""What the plant's sensors read, and how wrong they are."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from simtools import JointPDController, command, moved, random_state, robot, run

from wbc.errors import PlantError
from wbc.sim import Mujoco, SensorNoise, Tiles
from wbc.sim.noise import NoiseGenerator
from wbc.state import State

pytest.importorskip("mujoco")

QUIET = SensorNoise.none()


def imu_rotation(r, state: State) -> np.ndarray:
    data = r.model.createData()
    pin.framesForwardKinematics(r.model, data, state.q)
    return data.oMf[r.frame_id(r.imu)].rotation


@pytest.mark.parametrize("name", ["talos", "g1", "romeo"])
def test_imu_of_a_robot_at_rest_measures_gravity_upwards(name):
    r = robot(name)
    with Mujoco(r, noise=QUIET) as plant:
        run(plant, 2.0, JointPDController(r))
        m = plant.measure()
        up = imu_rotation(r, plant.ground_truth()) @ m.accelerometer
    np.testing.assert_allclose(up, [0.0, 0.0, 9.81], atol=0.02)
    np.testing.assert_allclose(m.gyro, 0.0, atol=0.01)


def test_encoders_and_gyro_read_the_exact_state_of_the_instant():
    r = robot()
    random = np.random.default_rng(5)
    with Mujoco(r, noise=QUIET, ground_truth=True) as plant:
        plant.reset(random_state(r, random))
        for _ in range(3):
            plant.step(command(random.uniform(-10.0, 10.0, r.na)))
        m = plant.measure()
    state = m.ground_truth
    data = r.model.createData()
    pin.forwardKinematics(r.model, data, state.q, state.v)
    imu = pin.getFrameVelocity(r.model, data, r.frame_id(r.imu), pin.ReferenceFrame.LOCAL)
    np.testing.assert_array_equal(m.joint_position, state.q[7:])
    np.testing.assert_array_equal(m.joint_velocity, state.v[6:])
    np.testing.assert_allclose(m.gyro, imu.angular, atol=1e-12)


def test_the_accelerometer_reads_the_mean_specific_force_of_the_period():
    r = robot()
    random = np.random.default_rng(6)
    imu = r.frame_id(r.imu)

    def velocity(state: State) -> tuple[np.ndarray, np.ndarray]:
        data = r.model.createData()
        pin.forwardKinematics(r.model, data, state.q, state.v)
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        return pin.getFrameVelocity(r.model, data, imu, axes).linear, imu_rotation(r, state)

    with Mujoco(r, dt=2e-4, timestep=1e-4, noise=QUIET) as plant:
        plant.reset(random_state(r, random))
        plant.step(command(np.zeros(r.na)))
        before, R = velocity(plant.ground_truth())
        plant.step(command(np.zeros(r.na)))
        after, _ = velocity(plant.ground_truth())
        force = R.T @ ((after - before) / plant.dt - r.model.gravity.linear)
        scale = np.linalg.norm(force)
        np.testing.assert_allclose(plant.measure().accelerometer, force, atol=5e-3 * scale)


@pytest.mark.parametrize("name", ["talos", "g1"])
def test_accelerometer_reading_agrees_with_the_forces_of_the_step(name):
    r = robot(name)
    random = np.random.default_rng(7)
    imu, data = r.frame_id(r.imu), r.model.createData()
    with Mujoco(r, dt=1e-3, timestep=1e-3, noise=QUIET) as plant:
        plant.reset(random_state(r, random))
        for _ in range(3):
            before = plant.ground_truth()
            plant.step(command(random.uniform(-10.0, 10.0, r.na)))
            R = pin.XYZQUATToSE3(before.q[:7]).rotation
            a = plant.data.qacc.copy()
            a[6:] = plant.data.qacc[6 + plant.coordinates.order]
            a[:3] = R.T @ a[:3] - np.cross(before.v[3:6], before.v[:3])
            pin.forwardKinematics(r.model, data, before.q, before.v, a)
            axes = pin.ReferenceFrame.LOCAL
            moving = pin.getFrameClassicalAcceleration(r.model, data, imu, axes).linear
            expected = moving - imu_rotation(r, before).T @ r.model.gravity.linear
            np.testing.assert_allclose(plant.measure().accelerometer, expected, atol=1e-8)


def test_ground_truth_is_only_given_when_asked_for():
    r = robot()
    with Mujoco(r) as plant:
        assert plant.measure().ground_truth is None
    with Mujoco(r, ground_truth=True) as plant:
        np.testing.assert_allclose(plant.measure().ground_truth.q, r.standing().q, atol=1e-15)


def test_measuring_twice_in_a_tick_gives_the_same_reading():
    r = robot()
    with Mujoco(r) as plant:
        first = plant.measure()
        assert plant.measure() is first
        kept = first.joint_position.copy()
        plant.step(command(np.zeros(r.na)))
        assert plant.measure() is not first
        np.testing.assert_array_equal(first.joint_position, kept)


def test_noise_is_reproducible_and_differs_between_seeds():
    r = robot()
    hold = JointPDController(r)

    def end(seed: int) -> tuple[np.ndarray, np.ndarray]:
        with Mujoco(r, seed=seed) as plant:
            run(plant, 0.1, hold)
            once = plant.measure().joint_velocity.copy(), plant.ground_truth().q
            plant.reset()
            run(plant, 0.1, hold)
            np.testing.assert_array_equal(plant.measure().joint_velocity, once[0])
            np.testing.assert_array_equal(plant.ground_truth().q, once[1])
            return once

    assert np.abs(end(1)[0] - end(2)[0]).max() > 0.01


def test_noise_has_the_stated_deviations():
    na, feet, n = 10, 2, 4000
    sigma = SensorNoise()
    noise = NoiseGenerator(sigma, na, feet, seed=7)
    exact = np.zeros(2 * na + 6 + 6 * feet)
    exact[-4] = 400.0  # vertical force of the second foot
    errors = np.array([noise.add_to(exact) for _ in range(n)]) - exact
    gyro, accelerometer = errors[:, 20:23], errors[:, 23:26]
    spread = errors.std(axis=0)
    np.testing.assert_allclose(spread[:10], sigma.encoder, rtol=0.1)
    np.testing.assert_allclose(spread[10:20], sigma.velocity, rtol=0.1)
    np.testing.assert_allclose(spread[20:23], sigma.gyro, rtol=0.1)
    np.testing.assert_allclose(spread[23:26], sigma.accelerometer, rtol=0.1)
    np.testing.assert_allclose(gyro.mean(axis=0), noise.gyro_bias, atol=5e-4)
    np.testing.assert_allclose(accelerometer.mean(axis=0), noise.accelerometer_bias, atol=5e-3)
    np.testing.assert_allclose(spread[26:29], sigma.force, rtol=0.1)
    np.testing.assert_allclose(spread[29:32], sigma.torque, rtol=0.1)
    loaded = np.hypot(sigma.force, sigma.force_share * 400.0)
    assert spread[-4] == pytest.approx(loaded, rel=0.1)
    # White: no sample tells the next; channels are independent of each other.
    white = errors[:, :20] / spread[:20]
    assert np.abs(np.mean(white[1:] * white[:-1], axis=0)).max() < 0.08
    assert np.abs(np.corrcoef(errors.T) - np.eye(errors.shape[1])).max() < 0.1


def test_biases_spread_over_seeds_as_stated():
    draws = [NoiseGenerator(SensorNoise(), 1, 0, seed) for seed in range(400)]
    assert np.std([d.gyro_bias for d in draws]) == pytest.approx(0.002, rel=0.1)
    assert np.std([d.accelerometer_bias for d in draws]) == pytest.approx(0.02, rel=0.1)


def test_scaled_noise_scales_every_deviation():
    worse = SensorNoise().scaled(3.0)
    assert worse.encoder == pytest.approx(3e-3)
    assert worse.torque == pytest.approx(0.3)
    assert SensorNoise().scaled(0.0) == QUIET


def test_sensors_without_noise_read_the_exact_values():
    exact = np.arange(18.0)
    np.testing.assert_array_equal(NoiseGenerator(QUIET, 3, 1, 0).add_to(exact), exact)


@pytest.mark.parametrize("field", ["height", "size", "extent"])
def test_tiles_of_zero_size_are_refused(field):
    with pytest.raises(PlantError, match=field):
        Tiles(**{field: 0.0})


def test_readings_do_not_depend_on_position_and_heading():
    r = robot()
    hold = JointPDController(r)
    readings = []
    # A hair deep in the ground: at its very surface rounding decides which corners touch it.
    for shift, yaw in (((0.0, 0.0, -1e-6), 0.0), ((80.0, 60.0, -1e-6), -2.0)):
        with Mujoco(r, noise=QUIET) as plant:
            plant.reset(moved(r.standing(), shift, yaw))
            run(plant, 0.2, hold)
            m = plant.measure()
            feet = np.concatenate(list(m.foot_wrenches.values()))
            readings.append(np.concatenate([m.gyro, m.accelerometer, feet]))
    np.testing.assert_allclose(readings[1], readings[0], atol=1e-4)
