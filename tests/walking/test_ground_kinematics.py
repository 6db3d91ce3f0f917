"""What gait and stabilizer read by one call equals what the kinematics say one by one."""

import copy

import numpy as np
import pinocchio as pin
import pytest

import wbc
from wbc.gait import Feet, Placement
from wbc.geometry.planar import ground_point, yaw_of
from wbc.kinematics import Kinematics
from wbc.walking.ground_kinematics import GroundKinematics


@pytest.fixture(scope="module", params=["talos", "g1"])
def robot(request: pytest.FixtureRequest) -> wbc.Robot:
    return wbc.load(request.param)


def _feet(kin: Kinematics) -> Feet:
    """Both soles by Pinocchio's frames."""
    frames = [kin.frame(sole.name) for sole in kin.robot.soles]
    return Feet(
        *(
            Placement(ground_point(T.translation), yaw_of(T.rotation), float(T.translation[2]))
            for T in frames
        )
    )


def _random_state(robot: wbc.Robot, seed: int) -> wbc.State:
    rng = np.random.default_rng(seed)
    standing = robot.standing()
    q = pin.integrate(robot.model, standing.q, 0.3 * rng.standard_normal(robot.nv))
    return wbc.State(q, rng.standard_normal(robot.nv))


def test_soles_and_com_equal_those_of_the_kinematics(robot: wbc.Robot) -> None:
    kin = Kinematics(robot, robot.standing())
    ground = GroundKinematics(kin)
    for seed in range(5):
        kin.update(_random_state(robot, seed))
        feet, com, velocity = ground.read()
        expected = _feet(kin)
        for side in ("left", "right"):
            np.testing.assert_allclose(feet.of(side), expected.of(side), atol=1e-13)
        np.testing.assert_allclose((com.real, com.imag), kin.p_com[:2], atol=1e-13)
        np.testing.assert_allclose((velocity.real, velocity.imag), kin.v_com[:2], atol=1e-13)
        for sole, slope in zip(robot.soles, ground.slopes, strict=True):
            x, y, z = kin.frame(sole.name).rotation[:, 2]
            if z > 0.5:
                assert slope == pytest.approx(complex(-x / z, -y / z), abs=1e-12)
        np.testing.assert_allclose(kin.v_com, kin.J_com @ kin.state.v, atol=1e-12)


def test_a_copy_follows_its_own_kinematics(robot: wbc.Robot) -> None:
    kin = Kinematics(robot, robot.standing())
    other_kin, other = copy.deepcopy((kin, GroundKinematics(kin)))
    other_kin.update(_random_state(robot, 1))
    feet, _, _ = other.read()
    np.testing.assert_allclose(feet.left, _feet(other_kin).left, atol=1e-13)
