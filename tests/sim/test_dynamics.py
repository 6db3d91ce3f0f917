"""The plant moves as Pinocchio says it does."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simtools import command, random_state, robot

from wbc.errors import MissingExtra, PlantError
from wbc.sim import Mujoco, SensorNoise
from wbc.sim.coordinates import CoordinateMap
from wbc.state import State

mujoco = pytest.importorskip("mujoco")

ROBOTS = ["talos", "g1", "romeo", "icub", "simple_humanoid"]


def world_blocks(state: State) -> np.ndarray:
    """(nv, nv) from Pinocchio's generalised velocity to MuJoCo's, joints in the same order."""
    blocks = np.eye(state.v.size)
    blocks[:3, :3] = pin.XYZQUATToSE3(state.q[:7]).rotation
    return blocks


def loaded(plant: Mujoco, state: State, tau: np.ndarray) -> None:
    plant.data.qpos[:], plant.data.qvel[:] = plant.coordinates.to_plant(state)
    plant.data.ctrl[:] = tau
    mujoco.mj_forward(plant.model, plant.data)


@pytest.mark.parametrize("name", ROBOTS)
def test_mass_matrix_bias_and_forward_dynamics_agree_with_pinocchio(name):
    r = robot(name)
    random = np.random.default_rng(1)
    data = r.model.createData()
    with Mujoco(r, collisions="soles") as plant:  # random limbs would touch each other
        order = np.concatenate([np.arange(6), 6 + plant.coordinates.order])
        for _ in range(5):
            state = random_state(r, random)
            tau = random.uniform(-1.0, 1.0, r.na) * r.tau_max
            loaded(plant, state, tau)
            assert plant.data.ncon == 0
            W = world_blocks(state)
            M = np.zeros((r.nv, r.nv))
            mujoco.mj_fullM(plant.model, plant.data, M)
            M = M[np.ix_(order, order)]
            M_pin = pin.crba(r.model, data, state.q)
            M_pin = np.triu(M_pin) + np.triu(M_pin, 1).T
            np.testing.assert_allclose(M, W @ M_pin @ W.T, atol=1e-9)
            # MuJoCo's zero acceleration is another than Pinocchio's: the axes move.
            still = plant.coordinates.to_plant_acceleration(state, np.zeros(r.nv))[order]
            bias = W @ pin.nonLinearEffects(r.model, data, state.q, state.v) - M @ still
            np.testing.assert_allclose(plant.data.qfrc_bias[order], bias, atol=1e-9)
            a = pin.aba(r.model, data, state.q, state.v, np.concatenate([np.zeros(6), tau]))
            expected = plant.coordinates.to_plant_acceleration(state, a)
            scale = np.abs(expected).max()
            np.testing.assert_allclose(plant.data.qacc / scale, expected / scale, atol=1e-9)


@pytest.mark.parametrize("name", ROBOTS)
def test_reset_state_is_read_back_exactly(name):
    r = robot(name)
    state = random_state(r, np.random.default_rng(2))
    with Mujoco(r) as plant:
        plant.reset(state)
        back = plant.ground_truth()
    np.testing.assert_allclose(back.q, state.q, atol=1e-15)
    np.testing.assert_allclose(back.v, state.v, atol=1e-14)


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1), order=st.permutations(list(range(6))))
def test_conversion_to_mujoco_and_back_is_exact_for_any_joint_order(seed, order):
    random = np.random.default_rng(seed)
    q, v = random.standard_normal(13), random.standard_normal(12)
    q[3:7] /= np.linalg.norm(q[3:7])
    convention = CoordinateMap(np.array(order))
    qpos, qvel = convention.to_plant(State(q, v))
    assert qpos[3] == q[6]
    np.testing.assert_array_equal(qpos[7:][order], q[7:])
    np.testing.assert_allclose(qvel[:3] @ qvel[:3], v[:3] @ v[:3], rtol=1e-12)
    back = convention.to_state(qpos, qvel)
    np.testing.assert_array_equal(back.q, q)
    np.testing.assert_allclose(back.v, v, atol=1e-14)


def test_velocity_convention_is_the_derivative_of_the_motion():
    r = robot()
    state = random_state(r, np.random.default_rng(3))
    with Mujoco(r) as plant:
        plant.reset(state)
        h = 1e-7
        mujoco.mj_integratePos(plant.model, plant.data.qpos, plant.data.qvel, h)
        moved_q = plant.coordinates.to_state(plant.data.qpos, plant.data.qvel).q
    step = pin.difference(r.model, state.q, moved_q) / h
    np.testing.assert_allclose(step, state.v, atol=1e-5)


def test_free_fall_conserves_momentum_and_energy():
    r = robot()
    state = random_state(r, np.random.default_rng(4))
    state = State(state.q, 0.3 * state.v)
    data = r.model.createData()

    def account(s: State) -> tuple[np.ndarray, float, np.ndarray]:
        pin.computeCentroidalMomentum(r.model, data, s.q, s.v)
        rotors = 0.5 * float(np.sum(r.model.armature * s.v**2))
        energy = pin.computeMechanicalEnergy(r.model, data, s.q, s.v) + rotors
        return data.hg.vector.copy(), energy, np.array(data.com[0])

    before, energy, _ = account(state)
    duration = 0.05
    with Mujoco(r, dt=1e-4, timestep=1e-4, noise=SensorNoise.none()) as plant:
        plant.reset(state)
        idle = command(np.zeros(r.na))
        for _ in range(round(duration / plant.dt)):
            plant.step(idle)
        after, energy_after, _ = account(plant.ground_truth())
        assert plant.data.nefc == 0, "a joint stop interfered"
        assert not plant.measure().foot_wrenches["left_sole"].any()
        np.testing.assert_allclose(plant.measure().accelerometer.shape, (3,))
    gained = after - before
    np.testing.assert_allclose(gained[:2], 0.0, atol=1e-4)
    assert gained[2] == pytest.approx(-r.mass * 9.81 * duration, rel=1e-6)
    scale = np.linalg.norm(before[3:])
    np.testing.assert_allclose(gained[3:], 0.0, atol=2e-3 * scale)
    kinetic = pin.computeKineticEnergy(r.model, data, state.q, state.v)
    assert abs(energy_after - energy) < 5e-3 * kinetic


def test_importing_wbc_sim_does_not_import_mujoco():
    code = "import sys, wbc.sim; sys.exit('mujoco' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_missing_mujoco_is_an_error_with_its_pip_command(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingExtra, match=r"wbc\[sim\]"):
        Mujoco(robot())


@pytest.mark.parametrize(
    "times",
    [{"dt": 0.0025}, {"timestep": 0.0}, {"latency": 0.0005}, {"dt": 0.0}, {"latency": -0.001}],
)
def test_times_that_are_no_multiple_of_the_timestep_are_refused(times):
    with pytest.raises(PlantError):
        Mujoco(robot(), **times)
