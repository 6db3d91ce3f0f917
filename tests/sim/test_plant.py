"""Ground, motors and pushes of the plant."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from simtools import JointPDController, command, moved, robot, roll_pitch_yaw, run

from wbc.errors import FrameNotFound, PlantError, StateError
from wbc.sim import Flat, Mujoco, SensorNoise, Tiles
from wbc.state import State

mujoco = pytest.importorskip("mujoco")

QUIET = SensorNoise.none()


def momentum(r, state: State) -> np.ndarray:
    data = r.model.createData()
    pin.computeCentroidalMomentum(r.model, data, state.q, state.v)
    return data.hg.linear.copy()


@pytest.mark.parametrize("name", ["talos", "g1", "romeo", "simple_humanoid"])
def test_ground_forces_carry_the_weight_of_a_standing_robot(name):
    r = robot(name)
    hold = JointPDController(r)
    weight = 9.81 * r.mass
    with Mujoco(r, noise=QUIET) as plant:
        run(plant, 1.0, hold)
        total = sum(force for _, force in plant.contacts())
        np.testing.assert_allclose(total, [0.0, 0.0, weight], atol=0.02 * weight)
        soles = sum(w[2] for w in plant.measure().foot_wrenches.values())
        assert soles == pytest.approx(weight, rel=0.02)
        heights = [point[2] for point, _ in plant.contacts()]
        assert len(heights) >= 6
        assert min(heights) > -5e-4, "the soles sink in"
        assert np.abs(roll_pitch_yaw(plant.ground_truth())[:2]).max() < 0.02


def test_foot_sensors_agree_with_the_contact_forces():
    r = robot()
    hold = JointPDController(r)
    with Mujoco(r, noise=QUIET) as plant:
        run(plant, 0.5, hold)
        state = plant.ground_truth()
        data = r.model.createData()
        pin.framesForwardKinematics(r.model, data, state.q)
        # Over one period of a robot at rest the mean is the value.
        for sole in r.soles:
            T = data.oMf[sole.frame_id]
            wrench = np.zeros(6)
            for point, force in plant.contacts():
                local = T.actInv(point)
                if (
                    abs(local[0]) < sole.half_length + 0.01
                    and abs(local[1]) < 1.2 * sole.half_width
                ):
                    f = T.rotation.T @ force
                    wrench += np.concatenate([f, np.cross(local, f)])
            np.testing.assert_allclose(plant.foot_forces[sole.name], wrench, atol=1.0)


def test_first_measurement_is_that_of_standing_still():
    r = robot()
    with Mujoco(r, noise=QUIET) as plant:
        m = plant.measure()
        total = sum(w[2] for w in m.foot_wrenches.values())
        assert total == pytest.approx(9.81 * r.mass, rel=1e-9)
        assert np.linalg.norm(m.accelerometer) == pytest.approx(9.81, rel=1e-9)
        plant.reset(moved(r.standing(), (0.0, 0.0, 0.5), 0.0))
        m = plant.measure()
        assert not m.accelerometer.any()
        assert not any(w.any() for w in m.foot_wrenches.values())


@pytest.mark.parametrize("frame", [None, "base_link"])
@pytest.mark.parametrize("duration", [0.1, 0.0337, 0.0004])
def test_a_push_delivers_its_impulse(frame, duration):
    r = robot()
    impulse = np.array([20.0, -10.0, 5.0])
    start = moved(r.standing(), (0.0, 0.0, 5.0), 0.4)
    with Mujoco(r, noise=QUIET) as plant:
        plant.reset(start)
        plant.push(impulse, duration=duration, frame=frame)
        idle = command(np.zeros(r.na))
        for _ in range(60):
            plant.step(idle)
        gained = momentum(r, plant.ground_truth()) - momentum(r, start)
        fall = np.array([0.0, 0.0, -9.81 * r.mass * plant.time])
    np.testing.assert_allclose(gained, impulse + fall, atol=0.05)


def test_a_scheduled_push_acts_only_in_its_interval():
    r = robot()
    with Mujoco(r, noise=QUIET) as plant:
        plant.reset(moved(r.standing(), (0.0, 0.0, 5.0), 0.0))
        plant.schedule_push(0.02, [3.0, 0.0, 0.0], duration=0.01)
        idle = command(np.zeros(r.na))
        forces = []
        for _ in range(20):
            forces.append(plant.push_force[0])
            plant.step(idle)
        np.testing.assert_allclose(forces, [0.0] * 10 + [300.0] * 5 + [0.0] * 5)


def test_invalid_pushes_are_refused():
    with Mujoco(robot()) as plant:
        with pytest.raises(PlantError, match="impulse"):
            plant.push([1.0, 2.0])
        with pytest.raises(PlantError, match="impulse"):
            plant.push([np.nan, 0.0, 0.0])
        with pytest.raises(PlantError, match="duration"):
            plant.push([1.0, 0.0, 0.0], duration=0.0)
        with pytest.raises(PlantError, match="already"):
            plant.schedule_push(-1.0, [1.0, 0.0, 0.0])
        with pytest.raises(FrameNotFound, match="torso_2_link"):
            plant.push([1.0, 0.0, 0.0], frame="torso_2_lnk")


def test_torques_are_clipped_at_the_limits():
    r = robot()
    with Mujoco(r, noise=QUIET) as plant:
        asked = np.where(np.arange(r.na) % 2, 10.0, -10.0) * r.tau_max
        plant.step(command(asked))
        np.testing.assert_array_equal(plant.torque, np.sign(asked) * r.tau_max)
        # Mujoco's own account of what reached the joints.
        np.testing.assert_allclose(
            plant.data.qfrc_actuator[6 + plant.coordinates.order], plant.torque, rtol=1e-12
        )


def test_torques_that_are_not_finite_or_of_wrong_size_are_refused():
    r = robot()
    with Mujoco(r) as plant:
        tau = np.zeros(r.na)
        tau[3] = np.nan
        with pytest.raises(PlantError, match=r.joint_names[3]):
            plant.step(command(tau))
        with pytest.raises(PlantError, match="32 joints"):
            plant.step(command(np.zeros(5)))
        assert plant.time == 0.0


def test_latency_delays_commands_by_whole_physics_steps():
    r = robot()
    first, second = command(np.full(r.na, 0.1)), command(np.full(r.na, 0.2))
    with Mujoco(r, latency=0.003) as plant:
        plant.step(first)
        assert plant.torque[0] == 0.1, "nothing older was there to be done"
        plant.step(second)  # given at 2 ms, due at 5 ms
        assert plant.torque[0] == 0.1
        plant.step(second)  # acts in the second half of this period
        assert plant.torque[0] == 0.2


def test_an_invalid_initial_state_is_refused():
    r = robot()
    with Mujoco(r) as plant, pytest.raises(StateError, match="quaternion"):
        plant.reset(State(np.zeros(r.nq), np.zeros(r.nv)))


@pytest.mark.parametrize("terrain", [Flat(), Tiles(extent=2.0)])
def test_run_does_not_depend_on_position_and_heading_of_the_start(terrain):
    r = robot()
    hold = JointPDController(r)
    ends = []
    # A hair deep in the ground: at its very surface rounding decides which corners touch it.
    for shift, yaw in (((0.0, 0.0, -1e-6), 0.0), ((100.0, -40.0, -1e-6), 1.57)):
        with Mujoco(r, terrain=terrain, noise=QUIET) as plant:
            plant.reset(moved(r.standing(), shift, yaw))
            plant.push([5.0 * np.cos(yaw), 5.0 * np.sin(yaw), 0.0])
            run(plant, 0.3, hold)
            ends.append(plant.ground_truth())
    back = moved(
        State(ends[1].q - np.array([100.0, -40.0] + [0.0] * (r.nq - 2)), ends[1].v),
        (0.0, 0.0, 0.0),
        -1.57,
    )
    np.testing.assert_allclose(back.q[7:], ends[0].q[7:], atol=1e-6)
    np.testing.assert_allclose(back.q[:3], ends[0].q[:3], atol=1e-6)


def test_tiles_carry_a_robot_at_their_height_and_leave_the_start_flat():
    r = robot()
    hold = JointPDController(r)
    tiles = Tiles(height=0.03, size=1.0, extent=2.0, clearing=0.4, seed=3)
    boxes = tiles.boxes()
    tops = boxes[:, 2] + boxes[:, 5]
    assert tops.min() >= 0.0
    assert tops.max() <= 0.03
    assert len(np.unique(tops)) == len(tops)
    np.testing.assert_array_equal(boxes, Tiles(size=1.0, extent=2.0, seed=3).boxes())
    assert not np.array_equal(boxes, Tiles(size=1.0, extent=2.0, seed=4).boxes())
    # Feet inside the clearing stand on the floor.
    near = (np.abs(boxes[:, :2]) - boxes[:, 3:5]).max(axis=1)
    assert near.min() >= 0.4
    with Mujoco(r, terrain=Tiles(size=0.4, extent=2.0), noise=QUIET) as plant:
        run(plant, 0.2, hold)
        assert max(abs(p[2]) for p, _ in plant.contacts()) < 1e-3


def test_a_sole_on_a_slab_has_contacts_at_its_surface():
    r = robot()

    class Slab:
        def boxes(self) -> np.ndarray:
            return np.array([[0.0, 0.0, 0.01, 1.0, 1.0, 0.01]])

    with Mujoco(r, terrain=Slab(), noise=QUIET) as plant:
        plant.reset(moved(r.standing(), (0.0, 0.0, 0.02), 0.3))
        run(plant, 0.3, JointPDController(r))
        heights = [p[2] for p, _ in plant.contacts()]
        assert len(heights) >= 6
        assert min(force[2] for _, force in plant.contacts()) > 0.0
        np.testing.assert_allclose(heights, 0.02, atol=1e-3)


@pytest.mark.parametrize("place", [(0.0, 0.0), (7.3, -4.1), (11.9, 11.9), (30.0, 0.0)])
def test_tiles_near_the_robot_are_in_the_physics_wherever_it_is(place):
    """Only the tiles near the robot are in the physics: none of those may be missing."""
    r = robot()
    tiles = Tiles(height=0.03, size=0.3, extent=12.0, seed=5)
    boxes = tiles.boxes()
    start = moved(r.standing(), (50.0, 20.0, 0.0), 0.7)
    turn = pin.rpy.rpyToMatrix(0.0, 0.0, 0.7)
    with Mujoco(r, terrain=tiles, noise=QUIET) as plant:
        plant.reset(start)
        x, y, _ = turn @ np.array([*place, 0.0]) + np.array([50.0, 20.0, 0.0])
        plant.data.qpos[:2] = x, y
        plant.data.qpos[2] += 0.5
        plant.step(command(np.zeros(r.na)))
        random = np.random.default_rng(6)
        for dx, dy in random.uniform(-1.2, 1.2, (50, 2)):
            local = turn.T @ np.array([x + dx - 50.0, y + dy - 20.0, 0.0])
            over = (np.abs(boxes[:, :2] - local[:2]) < boxes[:, 3:5]).all(axis=1)
            height = float((boxes[over, 2] + boxes[over, 5]).max(initial=0.0))
            geom = np.array([-1], dtype=np.int32)
            above = np.array([x + dx, y + dy, 0.2])
            down = np.array([0.0, 0.0, -1.0])
            distance = mujoco.mj_ray(plant.model, plant.data, above, down, None, 1, -1, geom)
            assert 0.2 - distance == pytest.approx(height, abs=1e-9)


def test_divergence_is_an_error_with_time_and_cure():
    r = robot()
    state = r.standing()
    with Mujoco(r) as plant:
        plant.reset(State(state.q, np.full(r.nv, 1e12)))
        with pytest.raises(PlantError, match="diverged"):
            run(plant, 1.0, lambda _: command(np.zeros(r.na)))
