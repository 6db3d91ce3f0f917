"""The whole-body controller's commands obey the dynamics, the contacts and the limits."""

import numpy as np
import pinocchio as pin
import pytest
from coretools import (
    CONTACT_SETS,
    ROBOTS,
    contact_acceleration,
    contact_set,
    controller,
    few,
    force_of,
    random_state,
    residual,
    robot,
    robots,
    seeds,
    some,
    standing_state,
)
from hypothesis import given
from hypothesis import strategies as st

import wbc
from wbc.command import Status
from wbc.errors import ContactError, FrameNotFound, LimitError, StateError, TaskError, WbcError

GRAVITY = np.array([0.0, 0.0, -9.81])


@some
@given(robots, st.sampled_from(CONTACT_SETS), seeds)
def test_the_command_obeys_the_equations_of_motion(name, contacts, seed):
    bot = robot(name)
    state = standing_state(bot, seed)
    control = controller(bot, contacts)
    command = control.step(state)
    assert command.status is Status.OK, command.explanation
    gap = residual(bot, state, control.contacts, command)
    np.testing.assert_allclose(gap, 0.0, atol=1e-8)


@some
@given(robots, st.sampled_from(CONTACT_SETS), seeds)
def test_momentum_changes_by_the_wrenches_and_gravity(name, contacts, seed):
    bot = robot(name)
    state = standing_state(bot, seed)
    control = controller(bot, contacts)
    command = control.step(state)
    model, data = bot.model, bot.model.createData()
    pin.computeCentroidalMomentumTimeVariation(model, data, state.q, state.v, command.acceleration)
    kin = wbc.Kinematics(bot, state)
    force, moment = bot.mass * GRAVITY, np.zeros(3)
    for contact in control.contacts:
        T = kin.frame(contact.frame)
        f, m = np.split(T.rotation @ command.wrenches[contact.name].reshape(2, 3).T, 2, axis=1)
        force = force + f.ravel()
        moment = moment + m.ravel() + np.cross(T.translation - kin.p_com, f.ravel())
    np.testing.assert_allclose(data.dhg.linear, force, atol=1e-7)
    np.testing.assert_allclose(data.dhg.angular, moment, atol=1e-7)


@some
@given(robots, st.sampled_from(CONTACT_SETS), seeds)
def test_exact_contacts_meet_their_acceleration_and_forces_stay_in_their_cones(
    name, contacts, seed
):
    bot = robot(name)
    state = standing_state(bot, seed)
    control = controller(bot, contacts)
    command = control.step(state)
    assert command.status is Status.OK, command.explanation
    for contact in control.contacts:
        force = force_of(contact, command)
        assert (contact.cone @ force).max() < 1e-6
        assert force[2] > -1e-6
        velocity, acceleration = contact_acceleration(bot, state, contact, command)
        tolerance = 1e-7 if contact.motion_weight is None else 2.0
        np.testing.assert_allclose(acceleration, -contact.damping * velocity, atol=tolerance)


@some
@given(robots, seeds)
def test_torques_and_accelerations_stay_within_the_limits(name, seed):
    bot = robot(name)
    state = standing_state(bot, seed, speed=0.3)
    torque = wbc.TorqueLimit(bot, scale=0.8)
    acceleration = wbc.JointAccelerationLimit(bot, 30.0)
    control = controller(bot, "left", limits=[torque, acceleration])
    control.tasks[0].target = wbc.Kinematics(bot, state).p_com + np.array([0.3, 0.0, 0.0])
    command = control.step(state)
    if command.status is Status.OK:
        assert (np.abs(command.acceleration[6:]) <= 30.0 + 1e-6).all()
    assert (np.abs(command.tau) <= 0.8 * bot.tau_max + 1e-9).all()


@pytest.mark.parametrize("name", ROBOTS)
def test_without_contacts_the_robot_falls_freely(name):
    bot = robot(name)
    state = random_state(bot, 3, spread=0.1, speed=0.0)
    control = wbc.WholeBodyController(bot)
    control.add(wbc.PostureTask(bot, target=state.q[7:]))
    command = control.step(state)
    assert command.status is Status.OK
    assert command.wrenches == {}
    R = pin.XYZQUATToSE3(state.q[:7]).rotation
    np.testing.assert_allclose(R @ command.acceleration[:3], GRAVITY, atol=1e-4)
    np.testing.assert_allclose(command.acceleration[3:], 0.0, atol=1e-4)
    np.testing.assert_allclose(command.tau, 0.0, atol=1e-4)


@pytest.mark.parametrize("name", ROBOTS)
def test_a_robot_at_rest_stays_at_rest(name):
    bot = robot(name)
    state = bot.standing()
    # Talos' grippers stand on their stops: within the margin that position limits keep.
    control = controller(bot, "both", limits=[wbc.TorqueLimit(bot)])
    command = control.step(state)
    np.testing.assert_allclose(command.acceleration, 0.0, atol=2e-2)
    weight = sum(command.wrenches[s.name][2] for s in bot.soles)
    assert weight == pytest.approx(bot.mass * 9.81, rel=1e-3)


@few
@given(robots, seeds)
def test_an_exact_task_is_met_whatever_the_weighted_tasks(name, seed):
    bot = robot(name)
    state = standing_state(bot, seed)
    control = controller(bot, "left")
    exact = wbc.OrientationTask(bot.base, priority=0)
    exact.acceleration[:] = (0.3, -0.2, 0.1)
    control.add(exact)
    opposite = wbc.OrientationTask(bot.base, weight=1e3, name="the opposite")
    opposite.acceleration[:] = (-3.0, 2.0, -1.0)
    control.add(opposite)
    command = control.step(state)
    assert command.status is Status.OK, command.explanation
    at = wbc.Kinematics(bot, state).motion(bot.base)
    wanted = exact.acceleration - exact.kd * at.velocity[3:]
    got = (at.jacobian @ command.acceleration + at.bias)[3:]
    np.testing.assert_allclose(got, wanted, atol=1e-7)


def test_opposite_tasks_compromise_in_proportion_to_their_weights():
    bot = robot("talos")
    state = bot.standing()

    def lift(up: float, down: float) -> float:
        control = controller(bot, "both")
        control.remove(control.tasks[0])
        for weight, a in ((up, 1.0), (down, -1.0)):
            task = control.add(wbc.ComTask(weight=weight, name=f"com {a}"))
            task.acceleration[2] = a
        command = control.step(state)
        return float((wbc.Kinematics(bot, state).J_com @ command.acceleration)[2])

    assert lift(1e4, 1e4) == pytest.approx(0.0, abs=1e-2)
    assert lift(3e4, 1e4) == pytest.approx(0.5, abs=1e-2)
    assert lift(1e4, 3e4) == pytest.approx(-0.5, abs=1e-2)


def test_a_row_of_zero_weight_has_no_effect():
    bot = robot("talos")
    state = standing_state(bot, 4)
    plain = controller(bot, "both")
    extra = controller(bot, "both")
    task = extra.add(wbc.FrameTask(bot.torso, weight=0.0))
    task.acceleration[:] = 1e3
    np.testing.assert_allclose(extra.step(state).tau, plain.step(state).tau, atol=1e-7)


def test_targets_one_period_ahead_follow_the_acceleration():
    bot = robot("g1")
    state = standing_state(bot, 9)
    control = controller(bot, "both")
    command = control.step(state)
    a, dt = command.acceleration[6:], control.dt
    np.testing.assert_allclose(command.v_target, state.v[6:] + dt * a)
    np.testing.assert_allclose(command.q_target, state.q[7:] + dt * state.v[6:] + dt**2 / 2 * a)


@pytest.mark.parametrize("contacts", ["both", "left exact, right soft", "left"])
def test_torques_do_not_depend_on_position_and_heading(contacts):
    bot = robot("talos")
    state = standing_state(bot, 7)
    move = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, np.pi / 2), np.array([100.0, -60.0, 0.0]))
    moved = wbc.State(state.q.copy(), state.v)
    moved.q[:7] = pin.SE3ToXYZQUAT(move * pin.XYZQUATToSE3(state.q[:7]))
    taus = []
    for at, T in ((state, pin.SE3.Identity()), (moved, move)):
        control = controller(bot, contacts)
        com, trunk = control.tasks[0], control.tasks[1]
        kin = wbc.Kinematics(bot, state)
        com.target = T.act(kin.p_com + np.array([0.02, 0.01, -0.02]))
        com.acceleration = T.rotation @ np.array([0.3, 0.2, -0.1])
        trunk.target = T.rotation @ kin.frame(bot.torso).rotation @ pin.exp3(0.1 * np.ones(3))
        if contacts == "left":
            swing = control.add(wbc.FrameTask("right_sole", weight=300.0))
            swing.target = T * kin.frame("right_sole") * pin.SE3(np.eye(3), 0.05 * np.ones(3))
        taus.append([control.step(at).tau for _ in range(2)][-1])
    np.testing.assert_allclose(taus[1], taus[0], atol=1e-9)


def test_invalid_calls_are_refused_with_the_cure():
    bot = robot("talos")
    with pytest.raises(WbcError, match=r"dt = 0.0 must be positive"):
        wbc.WholeBodyController(bot, dt=0.0)
    with pytest.raises(LimitError, match="more than one TorqueLimit"):
        wbc.WholeBodyController(bot, limits=[wbc.TorqueLimit(bot), wbc.TorqueLimit(bot)])
    with pytest.raises(LimitError, match=r"horizon 0\.005 s.*shorter than.*0\.01"):
        wbc.WholeBodyController(bot, dt=0.01, limits=[wbc.JointPositionLimit(bot, horizon=0.005)])
    control = wbc.WholeBodyController(bot)
    control.add(wbc.ComTask())
    with pytest.raises(TaskError, match=r"a task named 'com' already.*another name"):
        control.add(wbc.ComTask())
    with pytest.raises(TaskError, match=r"no task 'angular momentum'.*there are: 'com'"):
        control.remove(wbc.AngularMomentumTask())
    with pytest.raises(FrameNotFound, match=r"'left_sol'.*did you mean 'left_sole'"):
        control.add(wbc.FrameTask("left_sol"))
    assert len(control.tasks) == 1
    with pytest.raises(FrameNotFound, match=r"'right_foot'.*did you mean"):
        control.set_contacts([wbc.PointContact("right_foot")])
    with pytest.raises(ContactError, match=r"same name.*left_sole.*name="):
        control.set_contacts([wbc.PointContact("left_sole"), wbc.PointContact("left_sole")])


@pytest.mark.parametrize(
    ("use", "error", "text"),
    [
        (
            lambda c: c.add("com"),
            TaskError,
            r"'com' is no task: add .*wbc\.ComTask",
        ),
        (lambda c: c.add(wbc.ComTask), TaskError, "is no task"),
        (lambda c: c.remove("com"), TaskError, r"no task 'com' to remove; there are: 'com'"),
        (
            lambda c: c.set_contacts(wbc.PointContact("left_sole")),
            ContactError,
            r"takes a list of all contacts; write set_contacts\(\[left_sole\]\)",
        ),
        (lambda c: c.set_contacts("left_sole"), ContactError, "'l' is no contact"),
        (lambda c: c.set_contacts(None), ContactError, "no list of contacts"),
        (lambda c: c.set_contacts([c.robot.soles[0]]), ContactError, "is no contact.*Surface"),
        (
            lambda c: c.step(c.robot.q_nominal),
            StateError,
            r"ndarray is no state.*State\(q, v\)",
        ),
        (lambda c: c.step(None), StateError, "NoneType is no state"),
    ],
)
def test_arguments_of_the_wrong_type_are_refused_without_changes(use, error, text):
    control = controller(robot("talos"), "both")
    tasks, contacts = list(control.tasks), control.contacts
    with pytest.raises(error, match=text):
        use(control)
    assert control.tasks == tasks
    assert control.contacts is contacts
    assert control.step(control.robot.standing()).status is Status.OK


def test_states_of_any_memory_layout_are_taken():
    robot = wbc.load("simple_humanoid")
    zero = np.zeros(robot.nv)
    commands = []
    columns = np.column_stack((robot.q_nominal, robot.q_nominal))
    for q in (robot.q_nominal.copy(), robot.q_nominal, columns[:, 0], robot.q_nominal.tolist()):
        controller = wbc.WholeBodyController(robot)
        controller.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in robot.soles])
        controller.add(wbc.PostureTask(robot))
        commands.append(controller.step(wbc.State(q, zero)))
        assert commands[-1].status is Status.OK
        assert (commands[-1].tau == commands[0].tau).all()


def test_a_posture_target_that_is_not_finite_is_refused_or_named():
    bot = robot("talos")
    with pytest.raises(TaskError, match=r"target\[0\] \(leg_left_1_joint\) is nan"):
        wbc.PostureTask(bot, np.full(bot.na, np.nan))
    control = controller(bot, "both")
    control.tasks[-1].target = np.full(bot.na, np.nan)
    command = control.step(bot.standing())
    assert command.status is Status.FAILED
    assert "task 'posture'" in command.explanation
    assert "target" in command.explanation
    assert np.isfinite(command.tau).all()


def test_two_contacts_of_one_frame_are_distinguished_by_name():
    bot = robot("talos")
    control = controller(bot, [*contact_set(bot, "left"), wbc.PointContact("right_sole")])
    assert set(control.step(bot.standing()).wrenches) == {"left_sole", "right_sole"}


def test_contacts_may_be_assigned_directly_when_their_frames_exist():
    bot = robot("talos")
    control = controller(bot, "both")
    control.contacts = tuple(contact_set(bot, "left"))
    assert control.step(bot.standing()).status is Status.OK
