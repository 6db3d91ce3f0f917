"""Tasks: their rows are the second derivative of their error."""

import numpy as np
import pinocchio as pin
import pytest
from coretools import few, random_state, robot, robots, seeds
from hypothesis import given
from hypothesis import strategies as st

import wbc
from wbc.errors import FrameNotFound, JointNotFound, TaskError

KP, KD = 30.0, 7.0


def make(kind: str, bot: wbc.Robot, state: wbc.State, seed: int) -> wbc.Task:
    """A task with a target close to the state."""
    rng = np.random.default_rng(seed)
    kin = wbc.Kinematics(bot, state)
    at = kin.frame("left_sole")
    near = 0.05 * rng.standard_normal(3)
    small = pin.exp3(0.1 * rng.standard_normal(3))
    gains = {"kp": KP, "kd": KD}
    if kind == "com":
        return wbc.ComTask(kin.p_com + near, **gains)
    if kind == "position":
        return wbc.PositionTask("left_sole", at.translation + near, **gains)
    if kind == "orientation":
        return wbc.OrientationTask("left_sole", small @ at.rotation, **gains)
    if kind == "pose":
        target = pin.SE3(small @ at.rotation, at.translation + near)
        return wbc.FrameTask("left_sole", target, **gains)
    joints = [str(j) for j in rng.permutation(bot.joint_names)[:7]]
    index = [bot.joint_index(j) for j in joints]
    return wbc.PostureTask(bot, state.q[7:][index] + 0.1, joints=joints, **gains)


def error(task: wbc.Task, kin: wbc.Kinematics) -> np.ndarray:
    """x_ref ⊖ x, written without the task's own code."""
    if isinstance(task, wbc.ComTask):
        return task.target - kin.p_com
    if isinstance(task, wbc.PostureTask):
        return task.target - kin.state.q[7:][task.index]
    at = kin.frame("left_sole")
    if isinstance(task, wbc.PositionTask):
        return task.target - at.translation
    if isinstance(task, wbc.OrientationTask):
        return pin.log3(task.target @ at.rotation.T)
    position = task.target.translation - at.translation
    return np.concatenate((position, pin.log3(task.target.rotation @ at.rotation.T)))


def rows(task: wbc.Task, bot: wbc.Robot, kin: wbc.Kinematics) -> tuple[np.ndarray, np.ndarray]:
    task.bind(bot)
    A, b = np.full((task.size, bot.nv), np.nan), np.full(task.size, np.nan)
    task.write(kin, A, b)
    return A, b


def moved(bot: wbc.Robot, state: wbc.State, a: np.ndarray, t: float) -> wbc.State:
    """After t at constant generalised acceleration (exact to third order in t)."""
    q = pin.integrate(bot.model, state.q, t * state.v + 0.5 * t * t * a)
    return wbc.State(q, state.v + t * a)


@few
@given(robots, st.sampled_from(["com", "position", "posture"]), seeds)
def test_the_error_follows_its_second_order_law(name, kind, seed):
    """ë = −kd ė − kp e by finite differences, where e lives in a vector space."""
    bot = robot(name)
    state = random_state(bot, seed, speed=0.3)
    kin = wbc.Kinematics(bot, state)
    task = make(kind, bot, state, seed)
    A, b = rows(task, bot, kin)
    a = np.linalg.lstsq(A, b, rcond=None)[0]
    h = 1e-4
    e = [error(task, wbc.Kinematics(bot, moved(bot, state, a, t))) for t in (-h, 0.0, h)]
    rate, second = (e[2] - e[0]) / (2 * h), (e[2] - 2 * e[1] + e[0]) / h**2
    np.testing.assert_allclose(second, -KD * rate - KP * e[1], atol=2e-4)


@few
@given(robots, st.sampled_from(["orientation", "pose"]), seeds)
def test_a_frames_spatial_acceleration_follows_its_law(name, kind, seed):
    """a = −kd v + kp e by finite differences of the velocity, for orientations too."""
    bot = robot(name)
    state = random_state(bot, seed, speed=0.3)
    kin = wbc.Kinematics(bot, state)
    task = make(kind, bot, state, seed)
    A, b = rows(task, bot, kin)
    a = np.linalg.lstsq(A, b, rcond=None)[0]
    h = 1e-5
    v = [wbc.Kinematics(bot, moved(bot, state, a, t)).motion("left_sole").velocity for t in (-h, h)]
    got = ((v[1] - v[0]) / (2 * h))[task.components]
    now = kin.motion("left_sole").velocity[task.components]
    np.testing.assert_allclose(got, -KD * now + KP * error(task, kin), atol=1e-4)


@few
@given(robots, seeds)
def test_angular_momentum_approaches_its_target(name, seed):
    bot = robot(name)
    state = random_state(bot, seed, speed=0.3)
    kin = wbc.Kinematics(bot, state)
    task = wbc.AngularMomentumTask(kp=4.0)
    task.target[:] = (1.0, -2.0, 0.5)
    task.rate[:] = (0.1, 0.2, 0.3)
    A, b = rows(task, bot, kin)
    a = np.linalg.lstsq(A, b, rcond=None)[0]
    h = 1e-5
    L = [wbc.Kinematics(bot, moved(bot, state, a, t)).angular_momentum for t in (-h, h)]
    wanted = task.rate + 4.0 * (task.target - kin.angular_momentum)
    np.testing.assert_allclose((L[1] - L[0]) / (2 * h), wanted, atol=1e-4)


@few
@given(robots, st.sampled_from(["com", "position", "orientation", "pose", "posture"]), seeds)
def test_velocity_and_acceleration_references_are_fed_forward(name, kind, seed):
    bot = robot(name)
    state = random_state(bot, seed)
    kin = wbc.Kinematics(bot, state)
    task = make(kind, bot, state, seed)
    A, b = rows(task, bot, kin)
    task.velocity = np.arange(1.0, task.size + 1)
    task.acceleration = np.ones(task.size)
    A2, b2 = rows(task, bot, kin)
    np.testing.assert_array_equal(A, A2)
    np.testing.assert_allclose(b2 - b, 1.0 + KD * task.velocity, atol=1e-9)


@pytest.mark.parametrize("kind", ["com", "position", "orientation", "pose"])
def test_a_task_without_target_holds_its_initial_value(kind):
    bot = robot("talos")
    there, later = random_state(bot, 1), random_state(bot, 2)
    task = {
        "com": lambda: wbc.ComTask(kp=KP, kd=0.0),
        "position": lambda: wbc.PositionTask("left_sole", kp=KP, kd=0.0),
        "orientation": lambda: wbc.OrientationTask("left_sole", kp=KP, kd=0.0),
        "pose": lambda: wbc.FrameTask("left_sole", kp=KP, kd=0.0),
    }[kind]()
    kin = wbc.Kinematics(bot, there)
    rows(task, bot, kin)
    np.testing.assert_allclose(error(task, kin), 0.0, atol=1e-9)
    held = task.target.copy()
    kin.update(later)
    rows(task, bot, kin)
    np.testing.assert_array_equal(np.array(task.target), np.array(held))
    assert np.abs(error(task, kin)).max() > 1e-2


def test_damping_is_critical_by_default():
    task = wbc.ComTask(kp=np.array([4.0, 9.0, 0.0]))
    np.testing.assert_allclose(task.kd, [4.0, 6.0, 0.0])


def test_posture_weights_can_be_given_by_joint_name():
    bot = robot("simple_humanoid")
    task = wbc.PostureTask(bot, weight={"neck": 2.0, "left_knee": 0.5})
    assert task.weight[bot.joint_index("neck")] == 2.0
    assert task.weight[bot.joint_index("left_knee")] == 0.5
    assert task.weight.sum() == 2.5
    np.testing.assert_array_equal(task.target, bot.q_nominal[7:])


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (lambda b: wbc.ComTask(weight=-1.0), "task 'com': weight = -1.0 must be finite and not"),
        (lambda b: wbc.ComTask(weight=np.ones(2)), r"weight has shape \(2,\).*number or \(3,\)"),
        (lambda b: wbc.ComTask(kp=np.nan), "kp = nan must be finite"),
        (lambda b: wbc.ComTask(kd=-2.0), "kd = -2.0 must be finite and not negative"),
        (lambda b: wbc.ComTask(priority=-2), r"priority -2 must be a whole number: 0 \(exact\)"),
        (lambda b: wbc.ComTask(np.zeros(2)), r"task 'com': target has shape \(2,\), expected"),
        (lambda b: wbc.ComTask((0.0, np.nan, 0.0)), r"target\[1\] \(y\) is nan, it must be finite"),
        (lambda b: wbc.FrameTask("torso", np.eye(4)), "target is a ndarray, not a pin.SE3"),
        (lambda b: wbc.OrientationTask("torso", np.ones((3, 3))), "not a .3, 3. rotation matrix"),
        (lambda b: wbc.OrientationTask("torso", -np.eye(3)), "not a .3, 3. rotation matrix"),
        (lambda b: wbc.PositionTask("torso", np.zeros(6)), r"shape \(6,\), expected \(3,\)"),
        (lambda b: wbc.PostureTask(b, np.zeros(3)), r"task 'posture': target has shape \(3,\)"),
        (lambda b: wbc.PostureTask(b, joints=["neck", "neck"]), "a joint is given twice: neck"),
        (
            lambda b: wbc.PostureTask(b, weight={"nek": 1.0}),
            "weight for 'nek', which is not one of its joints; did you mean 'neck'",
        ),
        (lambda b: setattr(wbc.ComTask(), "weight", -1.0), "weight = -1.0"),
        (lambda b: setattr(wbc.ComTask(), "kp", "stiff"), "kp"),
    ],
)
def test_an_invalid_task_is_refused(wrong, text):
    with pytest.raises(TaskError, match=text):
        wrong(robot("simple_humanoid"))


def test_changed_gains_are_validated():
    task = wbc.ComTask()
    with pytest.raises(ValueError, match="read-only"):
        task.weight[0] = -1.0


def test_missing_frames_and_joints_list_near_names():
    bot = robot("simple_humanoid")
    with pytest.raises(FrameNotFound, match=r"no frame 'torsso'.*did you mean 'torso"):
        wbc.FrameTask("torsso").bind(bot)
    with pytest.raises(JointNotFound, match=r"no joint 'left_kne'.*did you mean 'left_knee'"):
        wbc.PostureTask(bot, joints=["left_kne"])


def test_a_user_defined_task_is_added_like_any_other():
    class HeadDown(wbc.Task):
        """`q̈_neck = −kp q_neck`, by hand."""

        unit = "rad/s²"

        def write(self, kin, A, b):
            A[:] = 0.0
            A[0, 6 + self.joint] = 1.0
            b[0] = 5.0

    bot = robot("simple_humanoid")
    control = wbc.WholeBodyController(bot)
    task = HeadDown("head", 1, 1.0, 0.0, 0.0, 0)
    task.joint = bot.joint_index("neck")
    control.add(task)
    command = control.step(bot.standing())
    assert command.acceleration[6 + task.joint] == pytest.approx(5.0, abs=1e-7)
