"""Jumps are planned from a robot's limits: paths, profiles, plans and bounds, without physics."""

from functools import cache

import numpy as np
import pinocchio as pin
import pytest

import wbc
from wbc.errors import MotionError
from wbc.motions.jump import Jump
from wbc.motions.jumping import (
    JumpPath,
    JumpPlan,
    JumpTooHigh,
    find_path,
    jump_paths,
    plan_jump,
    take_off_bound,
)
from wbc.motions.jumping.profile import HopProfile, MinimumJerk, stroke

ROBOTS = ("talos", "g1", "simple_humanoid")
ARM_WEIGHT = 2e-5


@cache
def robot(name: str) -> wbc.Robot:
    return wbc.load(name)


@cache
def path(name: str) -> JumpPath:
    height = robot(name).com_height
    found = find_path(robot(name), 0.9 * height, 0.2 * height, ARM_WEIGHT)
    assert found is not None
    return found


@cache
def paths(name: str) -> list[JumpPath]:
    return jump_paths(robot(name))


@cache
def plan(name: str) -> JumpPlan:
    return plan_jump(robot(name), 0.05)


def limited(name: str, factor: float) -> wbc.Robot:
    """The robot with other torque limits; a model of its own."""
    weak = wbc.load(name)
    weak.model.effortLimit *= factor
    return weak


def sole_jacobians(robot: wbc.Robot, q: np.ndarray) -> np.ndarray:
    data = robot.model.createData()
    pin.computeJointJacobians(robot.model, data, q)
    pin.updateFramePlacements(robot.model, data)
    return np.vstack(
        [pin.getFrameJacobian(robot.model, data, s.frame_id, pin.LOCAL) for s in robot.soles]
    )


@pytest.mark.parametrize("name", ROBOTS)
def test_path_has_flat_resting_soles_and_its_com_over_their_middle(name):
    model, data, way = robot(name).model, robot(name).model.createData(), path(name)
    pin.framesForwardKinematics(model, data, robot(name).q_nominal)
    at_home = [data.oMf[s.frame_id].copy() for s in robot(name).soles]
    middle = 0.5 * (at_home[0].translation + at_home[1].translation)
    for z, q in zip(way.height, way.q, strict=True):
        com = pin.centerOfMass(model, data, q)
        pin.updateFramePlacements(model, data)
        np.testing.assert_allclose(com, [*middle[:2], z], atol=1e-8)
        for sole, home in zip(robot(name).soles, at_home, strict=True):
            assert np.abs(pin.log6(home.actInv(data.oMf[sole.frame_id])).vector).max() < 1e-8


@pytest.mark.parametrize("name", ROBOTS)
def test_path_has_no_angular_momentum_and_moves_legs_within_their_limits(name):
    model, data, way = robot(name).model, robot(name).model.createData(), path(name)
    legs = np.array([i - 6 for leg in robot(name).legs for i in leg])
    for q, tangent in zip(way.q, way.tangent, strict=True):
        spin = pin.computeCentroidalMomentum(model, data, q, tangent).angular
        assert abs(spin[1]) < 1e-9
        assert np.abs(spin).max() < 0.02, "what a mirrored robot has of roll and yaw cancels"
        play = np.minimum(q[7:] - robot(name).q_min, robot(name).q_max - q[7:])[legs]
        assert play.min() > 0.0


@pytest.mark.parametrize("name", ROBOTS)
def test_torques_on_the_ground_obey_the_equations_of_motion(name):
    model, data, way = robot(name).model, robot(name).model.createData(), path(name)
    k, rate, acceleration = 12, 0.7, 4.0
    v = way.tangent[k] * rate
    a = way.tangent[k] * acceleration + way.curvature[k] * rate**2
    force = pin.rnea(model, data, way.q[k], v, a)
    z = way.height[k : k + 1]
    force[6:] -= way.torque(way.stance, z, np.array([rate]), np.array([acceleration]))[0]
    J = sole_jacobians(robot(name), way.q[k])
    wrenches = np.linalg.lstsq(J.T, force, rcond=None)[0]
    assert np.abs(J.T @ wrenches - force).max() < 1e-6 * robot(name).weight, "M v̇ + h = Sᵀτ + Jᵀf"
    assert wrenches[[2, 8]].min() > 0.0


@pytest.mark.parametrize("name", ROBOTS)
def test_torques_in_the_air_need_no_force_from_outside(name):
    model, data, way = robot(name).model, robot(name).model.createData(), path(name)
    g = robot(name).gravity
    k, rate, acceleration = 12, -0.4, 20.0
    v = way.tangent[k] * rate
    a = way.tangent[k] * acceleration + way.curvature[k] * rate**2
    lift = np.zeros(model.nv)  # the soles accelerate by −g − z̈
    base = pin.Quaternion(way.q[k][3:7]).toRotationMatrix()
    lift[:3] = base.T @ np.array([0.0, 0.0, -g - acceleration])
    force = pin.rnea(model, data, way.q[k], v, a + lift)
    z = way.height[k : k + 1]
    torque = way.torque(way.flight, z, np.array([rate]), np.array([acceleration]))[0]
    np.testing.assert_allclose(force[6:], torque, atol=1e-6 * robot(name).weight)
    assert np.abs(force[:6]).max() < 0.02 * robot(name).weight


@pytest.mark.parametrize(
    ("start", "speed", "end", "begin"),
    [(0.7, 0.0, (0.8, 0.9, -9.81), 0.0), (0.8, -0.9, (0.65, 0.0, 0.0), -9.0)],
    ids=["push-off", "landing"],
)
def test_stroke_profile_meets_its_boundary_conditions(start, speed, end, begin):
    profile = stroke(start, speed, end, begin)
    np.testing.assert_allclose(profile.at(0.0), (start, speed, begin), atol=1e-12)
    np.testing.assert_allclose(profile.at(profile.duration), end, atol=1e-9)
    np.testing.assert_allclose(profile.end, end, atol=1e-9)


@pytest.mark.parametrize(
    "curve",
    [stroke(0.7, 0.0, (0.8, 0.9, -9.81)), MinimumJerk(0.3, 0.7, 0.8), HopProfile(0.16, 0.05, 0.1)],
    ids=lambda c: type(c).__name__,
)
def test_velocity_and_acceleration_of_a_profile_are_derivatives_of_its_position(curve):
    h = 1e-5
    for t in np.linspace(0.1, 0.9, 7) * curve.duration:
        before, now, after = (np.array(curve.at(t + s)) for s in (-h, 0.0, h))
        np.testing.assert_allclose((after - before)[:2] / (2 * h), now[1:], rtol=1e-5, atol=1e-4)


def test_foot_path_in_flight_starts_smoothly_clears_the_ground_and_lands_slowly():
    hop = HopProfile(0.16, 0.05, 0.1)
    np.testing.assert_allclose(hop.at(0.0), 0.0, atol=1e-12)
    assert hop.at(0.08)[0] == pytest.approx(0.05, abs=0.002)
    np.testing.assert_allclose(hop.at(0.16)[:2], [0.0, -0.1], atol=1e-9)
    np.testing.assert_allclose(hop.at(0.18), [-0.002, -0.1, 0.0], atol=1e-9)


@pytest.mark.parametrize("name", ROBOTS)
def test_plan_keeps_torque_and_velocity_limits_by_inverse_dynamics(name):
    """Configurations over time, differentiated numerically, through Pinocchio's own calls."""
    jump, bot = plan(name), robot(name)
    model, data, way, h = bot.model, bot.model.createData(), jump.path, 2e-3

    def q(t: float) -> np.ndarray:
        z = jump.push_off.at(t)[0]
        k = min(int(np.searchsorted(way.height, z, side="right")) - 1, len(way.height) - 2)
        share = (z - way.height[k]) / (way.height[k + 1] - way.height[k])
        return pin.interpolate(model, way.q[k], way.q[k + 1], float(share))

    worst = 0.0
    for t in np.linspace(h, jump.push_off.duration - h, 25):
        before, now, after = q(t - h), q(t), q(t + h)
        back, on = pin.difference(model, now, before), pin.difference(model, now, after)
        v, a = (on - back) / (2 * h), (on + back) / h**2
        force = pin.rnea(model, data, now, v, a)
        J = sole_jacobians(bot, now)
        halves = np.linalg.lstsq(J[:, :6].T, force[:6], rcond=None)[0]
        torque = np.abs(force - J.T @ halves)[6:] / bot.tau_max
        worst = max(worst, float(torque.max()))
        assert (np.abs(v[6:]) <= bot.v_max).all()
    assert worst <= 1.0
    assert worst <= jump.torque_share + 0.1, "the path is straight between its points"
    assert jump.holding_effort <= 0.95


@pytest.mark.parametrize("name", ROBOTS)
def test_plan_is_ballistic_and_clears_what_was_asked(name):
    jump = plan(name)
    g = robot(name).gravity
    assert jump.clearance == 0.05
    assert jump.rise == pytest.approx(jump.speed**2 / (2 * g))
    assert jump.flight.duration == pytest.approx(2 * jump.speed / g)
    height, speed, acceleration = jump.push_off.end
    assert (height, speed) == pytest.approx((jump.take_off, jump.speed))
    assert acceleration == pytest.approx(-g), "the ground's force has ended at take-off"


@pytest.mark.parametrize("name", ["g1", "simple_humanoid"])
def test_take_off_speed_of_every_plan_is_within_the_bound(name):
    bound = take_off_bound(robot(name), paths(name))
    for jump in (plan(name), plan_jump(robot(name), 0.1)):
        assert jump.speed <= bound.speed
    assert bound.rise == pytest.approx(bound.speed**2 / (2 * robot(name).gravity))


def test_take_off_bound_grows_with_the_torque_limits():
    name = "simple_humanoid"
    speeds = [take_off_bound(limited(name, f), paths(name)).speed for f in (0.15, 0.3, 0.6, 1.0)]
    assert speeds == sorted(speeds)
    assert speeds[0] < 0.6 < 2.0 < speeds[-1]


def test_take_off_bound_is_set_by_the_named_joint():
    """Raising the named limit raises the bound; raising any other joint's does less."""
    name = "simple_humanoid"
    bot = limited(name, 0.25)
    ways = jump_paths(bot)
    bound = take_off_bound(bot, ways)
    gains = {}
    for joint in ("hip_pitch", "knee", "ankle_pitch", "hip_roll"):
        stronger = limited(name, 0.25)
        for side in ("left", "right"):
            index = stronger.joint_index(f"{side}_{joint}")
            stronger.model.effortLimit[6 + index] *= 1.1
            stronger.model.velocityLimit[6 + index] *= 1.1
        gains[joint] = take_off_bound(stronger, ways).speed - bound.speed
    assert bound.joint == "left_" + max(gains, key=lambda joint: gains[joint])
    assert max(gains.values()) > 0.0


@pytest.mark.slow
def test_jump_beyond_the_bound_is_refused_with_bound_and_limiting_joint():
    weak = limited("simple_humanoid", 0.4)
    with pytest.raises(JumpTooHigh, match=r"m/s at most.*knee.*ask for \d+ mm") as told:
        Jump(clearance=0.2).check(weak)
    assert isinstance(told.value, MotionError)
    assert 0.0 < told.value.bound.rise < 0.2
    asked = float(str(told.value).split("ask for ")[1].split(" mm")[0]) / 1e3
    assert plan_jump(weak, 0.95 * asked).holding_effort <= 0.95, (
        "what it is told to ask for, it can do"
    )


def test_jump_of_a_robot_too_weak_to_rise_is_refused():
    with pytest.raises(JumpTooHigh, match="cannot rise from any crouch for the torque of") as told:
        plan_jump(limited("simple_humanoid", 0.04), 0.05)
    assert told.value.bound.speed == 0.0


def test_take_off_of_a_robot_with_slow_legs_is_bounded_by_joint_velocity():
    with pytest.raises(JumpTooHigh, match="velocity") as told:
        plan_jump(robot("romeo"), 0.03)
    assert told.value.bound.quantity == "velocity"


@pytest.mark.parametrize("clearance", [0.0, -0.1, float("nan"), float("inf")])
def test_invalid_clearance_is_refused(clearance):
    with pytest.raises(MotionError, match="clearance"):
        Jump(clearance=clearance).check(robot("simple_humanoid"))
