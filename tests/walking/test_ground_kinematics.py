"""What gait and stabilizer read by one call equals what the kinematics say one by one."""

import copy

import numpy as np
import pinocchio as pin
import pytest

import wbc
from wbc.gait import Feet, Placement
from wbc.geometry.planar import ground_point, yaw_of
from wbc.kinematics import Kinematics
from wbc.robot.attitude import base_height
from wbc.walking.ground_kinematics import CentroidalMotion, GroundKinematics


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
    ground = GroundKinematics(robot, kin)
    for seed in range(5):
        kin.update(_random_state(robot, seed))
        feet, com = ground.read()
        expected = _feet(kin)
        for side in ("left", "right"):
            np.testing.assert_allclose(feet.of(side), expected.of(side), atol=1e-13)
        for sole, slope in zip(robot.soles, ground.slopes, strict=True):
            x, y, z = kin.frame(sole.name).rotation[:, 2]
            if z > 0.5:
                assert slope == pytest.approx(complex(-x / z, -y / z), abs=1e-12)
        for sole, speed in zip(robot.soles, ground.speeds, strict=True):
            assert speed == pytest.approx(np.linalg.norm(kin.motion(sole.name).velocity[:3]))
        np.testing.assert_allclose(ground.base, base_height(kin.state), atol=1e-12)
        v = com.velocity
        np.testing.assert_allclose((com.point.real, com.point.imag), kin.p_com[:2], atol=1e-13)
        np.testing.assert_allclose((v.real, v.imag, com.vertical_velocity), kin.v_com, atol=1e-12)
        np.testing.assert_allclose(kin.v_com, kin.J_com @ kin.state.v, atol=1e-12)
        data = robot.model.createData()
        L = pin.computeCentroidalMomentum(robot.model, data, kin.state.q, kin.state.v).angular
        turning = complex(L[1], -L[0]) / robot.weight
        assert com.centroidal_momentum == pytest.approx(turning, abs=1e-12)


def test_momentum_about_the_ground_changes_by_the_moment_of_the_grounds_force(
    robot: wbc.Robot,
) -> None:
    kin, rng, h = Kinematics(robot, robot.standing()), np.random.default_rng(3), 1e-5
    ground, model, data = GroundKinematics(robot, kin), robot.model, robot.model.createData()
    state = _random_state(robot, 3)
    acceleration = rng.standard_normal(robot.nv)

    def motion(time: float) -> tuple[CentroidalMotion, float]:
        """Return the motion of the centre of mass, and the height of the ground."""
        way = time * state.v + 0.5 * time * time * acceleration
        rate = pin.dIntegrate(model, state.q, way, pin.ArgumentPosition.ARG1)
        q = pin.integrate(model, state.q, way)
        kin.update(wbc.State(q, rate @ (state.v + time * acceleration)))
        feet, com = ground.read()
        return com, 0.5 * (feet.left.height + feet.right.height)

    (before, low), (after, high) = motion(-h), motion(h)
    now, level = motion(0.0)
    # The force that the ground has to exert is what inverse dynamics asks of the base.
    wrench = pin.Force(pin.rnea(model, data, state.q, state.v, acceleration)[:6])
    below = pin.SE3(np.eye(3), np.array([now.point.real, now.point.imag, level]))
    mx, my, _ = below.actInv(kin.base.act(wrench)).angular
    # These soles move: the ground rises between them.
    rising = now.vertical_velocity - (high - low) / (2.0 * h)
    expected = complex(my, -mx) / robot.weight + rising * now.velocity / robot.gravity
    rate = (after.momentum - before.momentum) / (2.0 * h)
    assert rate == pytest.approx(expected, abs=1e-6)


def test_a_copy_follows_its_own_kinematics(robot: wbc.Robot) -> None:
    kin = Kinematics(robot, robot.standing())
    other_kin, other = copy.deepcopy((kin, GroundKinematics(robot, kin)))
    other_kin.update(_random_state(robot, 1))
    feet, _ = other.read()
    np.testing.assert_allclose(feet.left, _feet(other_kin).left, atol=1e-13)
