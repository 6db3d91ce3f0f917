"""Velocities by inverse kinematics."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pinocchio as pin
import pytest
from coretools import few, random_state, robot, robots, seeds
from hypothesis import given
from hypothesis import strategies as st

import wbc
from wbc.errors import FrameNotFound, JointNotFound, StateError, TaskError
from wbc.ik import InverseKinematics, InverseKinematicsError, NoSolutionFound
from wbc.ik.compiled_program import CompiledVelocityProgram
from wbc.ik.configuration_kinematics import ConfigurationKinematics
from wbc.ik.velocity_program import Unknown, VelocityProblemLayout, VelocityProgram
from wbc.limits import (
    JointAccelerationLimit,
    JointJerkLimit,
    JointPositionLimit,
    JointVelocityLimit,
    LimitSet,
)
from wbc.tasks import AngularMomentumTask, JointTorqueTask

DT = 0.005


def panda() -> wbc.FixedBaseRobot:
    return wbc.load_fixed_base("panda")


def standing_ik(one: wbc.Robot) -> InverseKinematics:
    ik = InverseKinematics(one)
    for sole in one.soles:
        ik.add(wbc.FrameTask(sole.name, priority=0))
    ik.add(wbc.ComTask())
    ik.add(wbc.OrientationTask(one.torso))
    ik.add(wbc.PostureTask(one))
    return ik


class _Scaled(wbc.PositionTask):
    """A task of one's own, which defines only its second-order rows."""

    def write_velocity(self, kin, J, velocity, error):
        wbc.Task.write_velocity(self, kin, J, velocity, error)


@given(name=robots, seed=seeds, unknown=st.sampled_from(Unknown))
@few
def test_compiled_program_equals_the_one_in_numpy(name, seed, unknown):
    one, random = robot(name), np.random.default_rng(seed)
    hand = one.torso
    tasks = (
        wbc.ComTask(random.standard_normal(3), weight=random.uniform(1.0, 9.0, 3)),
        _Scaled(hand, random.standard_normal(3), kp=7.0, name="own"),
        wbc.OrientationTask(hand, pin.exp3(random.standard_normal(3)), kp=3.0, kd=2.0),
        AngularMomentumTask(),
        wbc.PostureTask(one, kp=5.0),
    )
    tasks[3].target[:] = random.standard_normal(3)
    exact = (wbc.FrameTask(one.soles[0].name),)
    exact[0].velocity[:] = random.standard_normal(6)
    for task in (*tasks, *exact):
        task.bind(one)
    position = JointPositionLimit(one)
    continuous = random.random(one.na) < 0.2
    position.lower = np.where(continuous, -np.inf, position.lower)
    position.upper = np.where(continuous, np.inf, position.upper)
    limits = LimitSet.sort(
        [position, JointVelocityLimit(one), JointAccelerationLimit(one, 30.0)], one, 0.0
    )
    state = random_state(one, seed)
    moving = np.array([*range(8, one.nv), *range(6)])
    layout = VelocityProblemLayout(one, tasks, exact, limits, moving, unknown, 1e-6)
    kin = ConfigurationKinematics(one, state.q)
    programs = VelocityProgram(layout), CompiledVelocityProgram(layout)
    ours, theirs = (program.build(kin, state.v[6:], DT) for program in programs)
    for array in ("H", "g", "C", "lb", "ub"):
        np.testing.assert_allclose(
            getattr(theirs, array), getattr(ours, array), rtol=1e-9, atol=1e-9
        )
    assert (ours.equality == theirs.equality).all()
    assert ours.finite
    assert theirs.finite


@pytest.mark.parametrize("name", ["talos", "g1"])
def test_feet_hold_still_while_the_com_goes_to_its_target(name):
    one = robot(name)
    ik = standing_ik(one)
    q = one.q_nominal.copy()
    ik.step(q, DT)
    feet = [ik.kinematics.frame(sole.name).copy() for sole in one.soles]
    com = ik.tasks[2]
    com.target = com.target + np.array([0.01, 0.02, -0.03])
    for _ in range(300):
        q = pin.integrate(one.model, q, DT * ik.step(q, DT))
    kin = ConfigurationKinematics(one, q)
    assert np.abs(kin.p_com - com.target)[:2].max() < 2e-3
    for sole, foot in zip(one.soles, feet, strict=True):
        assert np.linalg.norm(pin.log6(foot.actInv(kin.frame(sole.name))).vector) < 1e-4


def test_gain_of_one_over_dt_asks_for_the_target_within_a_step():
    one = panda()
    ik = InverseKinematics(one, limits=[])
    hand = ik.add(wbc.FrameTask("panda_hand", kp=1.0 / DT, kd=1.0))
    q = one.q_nominal.copy()
    ik.step(q, DT)
    shift = np.array([1e-4, -2e-4, 1e-4])
    hand.target = pin.SE3(hand.target.rotation, hand.target.translation + shift)
    q = pin.integrate(one.model, q, DT * ik.step(q, DT))
    reached = ConfigurationKinematics(one, q).frame("panda_hand").translation
    assert reached == pytest.approx(hand.target.translation, abs=1e-6)


def test_reference_velocity_is_followed():
    one = panda()
    ik = InverseKinematics(one)
    hand = ik.add(wbc.PositionTask("panda_hand"))
    hand.velocity[:] = (0.05, 0.02, -0.03)
    v = ik.step(one.q_nominal, DT)
    assert ik.kinematics.jacobian("panda_hand")[:3] @ v == pytest.approx(hand.velocity, abs=1e-5)


def test_a_fixed_base_and_joints_that_are_left_out_do_not_move():
    one = panda()
    ik = InverseKinematics(one, joints=one.joint_names[:4])
    ik.add(wbc.PositionTask("panda_hand", (0.4, 0.3, 0.4)))
    v = ik.step(one.q_nominal, DT)
    assert (v[:6] == 0.0).all()
    assert (v[10:] == 0.0).all()
    assert np.abs(v[6:10]).max() > 0.1
    talos = robot("talos")
    walking = InverseKinematics(talos, joints=["root_joint", "torso_1_joint"])
    walking.add(wbc.ComTask((0.1, 0.1, 0.9)))
    moved = np.flatnonzero(walking.step(talos.q_nominal, DT))
    assert set(moved) <= {*range(6), 6 + talos.joint_index("torso_1_joint")}


@given(seed=seeds, dt=st.sampled_from([0.002, 0.02]))
@few
def test_joint_limits_hold_whatever_is_asked_for_and_an_inadmissible_start_comes_back(seed, dt):
    one, random = panda(), np.random.default_rng(seed)
    speed = random.uniform(0.5, 3.0, one.na)
    position = JointPositionLimit(one, braking=random.uniform(2.0, 50.0, one.na))
    braking = JointAccelerationLimit(one, position.braking)
    limits = [braking, position, JointVelocityLimit(one, speed)]
    ik = InverseKinematics(one, joints=one.joint_names[:7], limits=limits)
    hand = ik.add(wbc.FrameTask("panda_hand", kp=1.0 / dt, kd=1.0))
    q, v = one.q_nominal.copy(), np.zeros(one.nv)
    outside = random.uniform(size=one.na) < 0.2
    outside[7:] = False  # the fingers
    q[7:] = random.uniform(position.lower, position.upper)
    q[7:][outside] = position.upper[outside] + 0.1
    beyond = np.maximum(q[7:] - position.upper, position.lower - q[7:])
    for k in range(int(4.0 / dt) if dt > 0.01 else 400):
        if k % 50 == 0:
            hand.target = pin.SE3(pin.exp3(random.standard_normal(3)), random.uniform(-1.5, 1.5, 3))
        before, v = v, ik.step(q, dt, v)
        assert (np.abs(v[6:]) <= speed + 1e-6).all()
        assert (np.abs(v - before)[6:] <= dt * position.braking + 1e-6).all()
        q = pin.integrate(one.model, q, dt * v)
        now = np.maximum(q[7:] - position.upper, position.lower - q[7:])
        inside = ~outside
        assert now[inside].max(initial=-1.0) <= 1e-6
        assert (now <= np.maximum(beyond, 0.0) + 1e-6).all()
    if dt > 0.01:
        assert now.max() < 1e-2


def test_accelerations_change_by_no_more_than_the_jerk_limit():
    one = panda()
    ik = InverseKinematics(one, joints=one.joint_names[:7], limits=[JointJerkLimit(one, 50.0)])
    ik.add(wbc.PostureTask(one, one.q_nominal[7:] + 0.3, kp=10.0, kd=1.0))
    q, v, a = one.q_nominal.copy(), np.zeros(one.nv), np.zeros(one.nv)
    for _ in range(20):
        velocity = ik.step(q, DT, v)
        acceleration = (velocity - v) / DT
        assert np.abs(acceleration - a).max() <= 50.0 * DT + 1e-6
        q, v, a = pin.integrate(one.model, q, DT * velocity), velocity, acceleration
    assert np.abs(a).max() > 1.0


def test_infeasible_tasks_raise_an_error_that_names_them():
    one = panda()
    ik = InverseKinematics(one)
    ik.add(wbc.PositionTask("panda_hand", (0.9, 0.0, 0.5), priority=0, kp=100.0, kd=1.0))
    with pytest.raises(NoSolutionFound, match="panda_hand position"):
        ik.step(one.q_nominal, DT)


def test_a_target_that_is_not_finite_is_named_in_a_step_and_in_a_search():
    one = panda()
    ik = InverseKinematics(one)
    hand = ik.add(wbc.FrameTask("panda_hand"))
    posture = ik.add(wbc.PostureTask(one))
    ik.step(one.q_nominal, DT)
    nowhere = pin.SE3(np.eye(3), np.array([0.5, np.nan, 0.5]))
    for task, target in ((hand, nowhere), (posture, np.nan * posture.target)):
        sound, task.target = task.target, target
        with pytest.raises(NoSolutionFound, match=f"'{task.name}' are not finite: target = .*nan"):
            ik.step(one.q_nominal, DT)
        with pytest.raises(NoSolutionFound, match=f"'{task.name}' are not finite"):
            ik.reach(one.q_nominal)
        task.target = sound
    ik.step(one.q_nominal, DT)


@pytest.mark.parametrize("name", ["kinova", "double_pendulum_continuous"])
def test_joints_that_turn_without_end_go_the_short_way_and_are_reached(name):
    one = wbc.load_fixed_base(name)
    assert np.isinf(one.q_max).any()
    ik = InverseKinematics(one)
    posture = ik.add(wbc.PostureTask(one, kp=1.0, kd=1.0))
    offset = np.where(np.isinf(one.q_max), 0.3, 0.0)
    for sign in (-1.0, 1.0):
        posture.target = one.q_nominal[7:] + sign * offset
        assert ik.step(one.q_nominal, DT)[6:] == pytest.approx(sign * offset, abs=1e-3)
        found = ik.reach(one.q_nominal)
        assert found.reached
        assert found.q[7:] == pytest.approx(posture.target, abs=1e-5)


def test_coupled_joints_move_together_and_are_left_alone_where_none_of_them_moves():
    one = panda()  # the second finger mimics the first
    ik = InverseKinematics(one)
    ik.add(wbc.PostureTask(one, np.array([0.02]), joints=["panda_finger_joint1"]))
    v = ik.step(one.q_nominal, DT)[6:]
    first, second = (one.joint_index(f"panda_finger_joint{k}") for k in (1, 2))
    assert v[first] > 1e-2
    assert v[second] == pytest.approx(v[first], abs=1e-6)
    found = ik.reach(one.q_nominal, targets=[ik.tasks[-1]])
    assert found.reached
    assert found.q[7 + second] == pytest.approx(0.02, abs=1e-4)
    assert not InverseKinematics(one, joints=one.joint_names[:7]).tasks


def test_copies_go_on_alike():
    one = panda()
    ik = InverseKinematics(one)
    ik.add(wbc.PositionTask("panda_hand", (0.5, 0.3, 0.4)))
    q = one.q_nominal
    ik.step(q, DT)
    first = [other.step(q, DT) for other in (ik, copy.deepcopy(ik), pickle.loads(pickle.dumps(ik)))]
    assert (first[0] == first[1]).all()
    assert (first[0] == first[2]).all()


def test_arguments_are_checked():
    one = panda()
    ik = InverseKinematics(one)
    hand = ik.add(wbc.PositionTask("panda_hand"))
    with pytest.raises(InverseKinematicsError, match="dt = 0"):
        ik.step(one.q_nominal, 0.0)
    with pytest.raises(StateError, match="shape"):
        ik.step(np.zeros(7), DT)
    with pytest.raises(InverseKinematicsError, match="v of shape"):
        ik.step(one.q_nominal, DT, np.zeros(3))
    with pytest.raises(JointNotFound):
        InverseKinematics(one, joints=["elbow"])
    with pytest.raises(InverseKinematicsError, match="fixed"):
        InverseKinematics(one, joints=["root_joint"])
    with pytest.raises(InverseKinematicsError, match="damping"):
        InverseKinematics(one, damping=0.0)
    with pytest.raises(TaskError, match="already"):
        ik.add(wbc.PositionTask("panda_hand"))
    with pytest.raises(FrameNotFound):
        ik.add(wbc.PositionTask("hand_of_god"))
    with pytest.raises(TaskError, match="no task"):
        ik.add(3)
    ik.add(JointTorqueTask(one, ["panda_joint1"]))
    with pytest.raises(TaskError, match="torques"):
        ik.step(one.q_nominal, DT)
    ik.remove(ik.tasks[-1])
    hand.target = np.array([np.nan, 0.0, 0.0])
    with pytest.raises(NoSolutionFound, match="not finite"):
        ik.step(one.q_nominal, DT)
    with pytest.raises(TaskError, match="no task 'com' to remove"):
        ik.remove(wbc.ComTask())
