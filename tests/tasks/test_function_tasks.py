"""Tasks on functions of the configuration: their rows are derivatives of their error."""

import copy

import numpy as np
import pinocchio as pin
import pytest
from coretools import along_velocity, controller, few, hand, random_state, robot, robots, seeds
from hypothesis import given
from hypothesis import strategies as st

import wbc
from wbc.errors import TaskError
from wbc.ik.configuration_kinematics import ConfigurationKinematics
from wbc.tasks import (
    FunctionRows,
    FunctionTask,
    JointCouplingTask,
    LookAtTask,
    LowAccelerationTask,
    ManipulabilityTask,
    RelativeFrameTask,
)

KINDS = ("look at", "relative frame", "joint coupling", "manipulability")
KP, KD = 30.0, 7.0


def make(kind: str, bot: wbc.Robot, state: wbc.State, seed: int) -> FunctionTask:
    """A task with a target close to the state, or anywhere where it is not a rotation."""
    rng = np.random.default_rng(seed)
    gains = {"kp": KP, "kd": KD}
    kin, frame = wbc.Kinematics(bot, state), hand(bot)
    if kind == "look at":
        place = kin.frame(frame).act(rng.standard_normal(3))
        return LookAtTask(frame, place, axis=rng.standard_normal(3), **gains)
    if kind == "relative frame":
        now = kin.frame("left_sole").actInv(kin.frame(frame))
        # The rate of a rotation's error is the angular velocity only where it is small.
        near = pin.SE3(pin.exp3(1e-5 * rng.standard_normal(3)), 0.1 * rng.standard_normal(3))
        return RelativeFrameTask(frame, "left_sole", now * near, **gains)
    if kind == "manipulability":
        return ManipulabilityTask(bot, frame, 10.0, **gains)
    chosen = {str(j): rng.uniform(-2.0, 2.0) for j in rng.permutation(bot.joint_names)[:3]}
    return JointCouplingTask(bot, chosen, 0.3, **gains)


def rows_at(task: FunctionTask, bot: wbc.Robot, state: wbc.State) -> FunctionRows:
    rows = FunctionRows(np.zeros((task.size, bot.nv)), np.zeros(task.size), np.zeros(task.size))
    task.write_function(wbc.Kinematics(bot, state), rows)
    return rows


@few
@given(robots, st.sampled_from(KINDS), seeds)
def test_jacobian_and_bias_are_the_derivatives_of_the_error(name, kind, seed):
    bot = robot(name)
    state = random_state(bot, seed, speed=0.3)
    task = make(kind, bot, state, seed)
    task.bind(bot)
    h = 1e-4
    before, now, after = along_velocity(bot, state, h, lambda at: rows_at(task, bot, at))
    rate = -(after.error - before.error) / (2.0 * h)
    np.testing.assert_allclose(now.J @ state.v, rate, rtol=1e-4, atol=1e-4)
    # In constant generalised velocity the rate of J v is the bias: exact for a rotation's rate too.
    second = (after.J - before.J) @ state.v / (2.0 * h)
    np.testing.assert_allclose(now.bias, second, rtol=1e-4, atol=1e-4)


@few
@given(st.sampled_from(KINDS), seeds)
def test_both_levels_follow_the_same_law(kind, seed):
    bot = robot("g1")
    state = random_state(bot, seed, speed=0.3)
    task = make(kind, bot, state, seed)
    task.bind(bot)
    task.velocity[:], task.acceleration[:] = 0.3, 0.5
    found = rows_at(task, bot, state)
    A, b = np.full((task.size, bot.nv), np.nan), np.full(task.size, np.nan)
    task.write(wbc.Kinematics(bot, state), A, b)
    wanted = 0.5 + KD * (0.3 - found.J @ state.v) + KP * found.error - found.bias
    np.testing.assert_allclose(b, wanted, atol=1e-9)
    J, velocity, error = A.copy(), b.copy(), b.copy()
    task.write_velocity(ConfigurationKinematics(bot, state.q), J, velocity, error)
    np.testing.assert_allclose(J, found.J, atol=1e-9)
    np.testing.assert_allclose(error, found.error, atol=1e-9)
    np.testing.assert_array_equal(velocity, 0.3)


def test_inverse_kinematics_reaches_all_of_them_at_once():
    bot = robot("talos")
    left, right = "gripper_left_joint", "gripper_right_joint"
    ik = wbc.InverseKinematics(bot)
    for sole in bot.soles:
        ik.add(wbc.FrameTask(sole.name, priority=0))
    ik.add(wbc.ComTask())
    held = ik.add(RelativeFrameTask(left, right))
    ik.step(bot.q_nominal, 0.01)
    held.target = held.target * pin.SE3(np.eye(3), np.array([0.05, 0.0, 0.02]))
    gaze = ik.add(LookAtTask("head_2_joint", (1.0, 0.4, 1.2)))
    couple = ik.add(JointCouplingTask(bot, {"torso_1_joint": 1.0, "head_1_joint": -0.5}))
    found = ik.reach(bot.q_nominal)
    assert found.reached, found.explanation
    kin = wbc.Kinematics(bot, wbc.State(found.q, np.zeros(bot.nv)))
    seen = kin.frame("head_2_joint").actInv(gaze.target)
    assert seen[0] / np.linalg.norm(seen) > 1.0 - 1e-9
    off = held.target.actInv(kin.frame(right).actInv(kin.frame(left)))
    assert np.linalg.norm(pin.log6(off).vector) < 1e-4
    assert couple.coefficients @ found.q[7:] == pytest.approx(0.0, abs=1e-5)


def test_a_frame_that_looks_straight_away_from_its_target_turns_round():
    panda = wbc.load_fixed_base("panda")
    ik = wbc.InverseKinematics(panda)
    kin = ConfigurationKinematics(panda, panda.q_nominal)
    behind = kin.frame("panda_hand").act(np.array([-1.0, 0.0, 0.0]))
    ik.add(LookAtTask("panda_hand", behind))
    assert ik.reach(panda.q_nominal).reached


def test_manipulability_rises_to_its_target_and_is_left_alone_above_it():
    panda = wbc.load_fixed_base("panda")
    q = panda.q_nominal.copy()
    q[7:] = np.clip(0.0, panda.q_min, panda.q_max)  # the arm nearly straight up
    task = ManipulabilityTask(panda, "panda_hand", 0.05, rows="pose")
    start = task.manipulability(q)
    ik = wbc.InverseKinematics(panda)
    ik.add(task)
    for _ in range(300):
        q = pin.integrate(panda.model, q, 0.01 * ik.step(q, 0.01))
    assert start < 0.03
    assert task.manipulability(q) == pytest.approx(0.05, rel=0.02)
    task.target = 0.04
    assert np.abs(ik.step(q, 0.01)).max() < 1e-6
    other = copy.deepcopy(task)
    assert other.manipulability(q) == task.manipulability(q)


def test_low_acceleration_keeps_the_velocity_before_the_step_or_damps_it():
    bot = robot("g1")
    ik = wbc.InverseKinematics(bot)
    ik.add(LowAccelerationTask(bot))
    v = np.zeros(bot.nv)
    v[6:] = np.linspace(-0.1, 0.1, bot.na)
    np.testing.assert_allclose(ik.step(bot.q_nominal, 0.01, v)[6:], v[6:], atol=1e-4)
    control = controller(bot, "none")
    for task in list(control.tasks):
        control.remove(task)
    control.add(LowAccelerationTask(bot, kd=3.0))
    command = control.step(wbc.State(bot.q_nominal, v))
    np.testing.assert_allclose(command.acceleration[6:], -3.0 * v[6:], atol=1e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_the_controller_accepts_them_in_every_formulation(kind):
    bot, torques = robot("simple_humanoid"), []
    state = random_state(bot, 3, spread=0.02, speed=0.1, place=0.1, tilt=0.02)
    for formulation in wbc.Formulation:
        control = controller(bot, "both", formulation=formulation)
        control.add(make(kind, bot, state, 3))
        command = control.step(state)
        assert command.status is wbc.command.Status.OK
        torques.append(command.tau)
    for tau in torques[1:]:
        np.testing.assert_allclose(tau, torques[0], atol=1e-5)


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (lambda b: LookAtTask("torso", (0.0, 0.0, 1.0), axis=np.zeros(3)), "has no direction"),
        (lambda b: RelativeFrameTask("torso", "torso"), "are both 'torso'"),
        (lambda b: RelativeFrameTask("torso", "head", 3), "target is a int, not a pin.SE3"),
        (lambda b: JointCouplingTask(b, {}), "not all of them zero"),
        (lambda b: JointCouplingTask(b, {"neck": np.nan}), "must be finite"),
        (lambda b: ManipulabilityTask(b, "torso", 1.0), "joints move the frame, fewer than its 3"),
        (lambda b: ManipulabilityTask(b, "left_hand", 0.0), "target 0.0 must be positive"),
        (lambda b: ManipulabilityTask(b, "left_hand", 1.0, rows="x"), "rows 'x' must be one of"),
        (lambda b: LowAccelerationTask(b, joints=["neck", "neck"]), "a joint is given twice"),
    ],
)
def test_an_invalid_task_is_refused(wrong, text):
    with pytest.raises(TaskError, match=text):
        wrong(robot("simple_humanoid"))
