"""A tick is solved again from what its QP was made of, whatever it was made of."""

import numpy as np
import pinocchio as pin
import pytest
from coretools import contact_set, hand, robot, sole_contact, standing_state
from random_cases import SixteenSidedSole

import wbc
from wbc.command import Status
from wbc.contacts import Contact
from wbc.errors import WbcError
from wbc.limits import AccelerationBound, Limit, SelfCollisionLimit
from wbc.qp.inputs import packed_text, packed_values
from wbc.recorded_tick import recorded_controller
from wbc.tasks import JointCouplingTask, JointTorqueTask

WORDS = 8000


class OwnTask(wbc.Task):
    unit = "m/s²"

    def write(self, kin, A, b):
        A[:] = kin.J_com[:1]
        b[:] = 0.5 - kin.bias_com[:1]


class OwnBound(AccelerationBound):
    name = "own bound"

    def __init__(self, robot):
        self._largest = np.linspace(5.0, 50.0, robot.na)

    def bounds(self, kin):
        return -self._largest, self._largest


class OwnLimit(Limit):
    def write(self, kin, rows):
        rows.A[0] = kin.J_com[2]
        rows.upper[0] = 0.05
        for F in rows.forces.values():
            F[0, 2] = 1e-4


class OwnContact(wbc.PointContact):
    def write(self, kin, J, a):
        Contact.write(self, kin, J, a)
        a *= 0.5


def plain(bot):
    control = wbc.WholeBodyController(bot)
    control.add(wbc.ComTask(weight=1000.0)).acceleration[:] = (1.0, 2.0, 0.0)
    control.add(wbc.FrameTask(hand(bot), name="hand", weight=[1, 2, 3, 4, 5, 6]))
    control.tasks[-1].velocity[:] = 0.2
    control.add(wbc.OrientationTask(bot.torso))
    control.add(wbc.AngularMomentumTask()).target[1] = 3.0
    control.add(wbc.PostureTask(bot, weight={bot.joint_names[3]: 2.0, bot.joint_names[9]: 0.1}))
    control.add(wbc.PostureTask(bot, name="rest"))
    control.set_contacts(contact_set(bot, "soles and hand"))
    return control


def exact(bot):
    control = plain(bot)
    control.tasks[1].priority = 0
    control.contacts[0].friction, control.contacts[1].max_force = 0.4, 100.0
    return control


def of_own_classes(bot):
    control = plain(bot)
    control.add(OwnTask("own", 1, 10.0, 0.0, 0.0, 1))
    control.add(OwnTask("own exact", 1, 10.0, 0.0, 0.0, 0))
    control.add(JointTorqueTask(bot, bot.joint_names[-3:])).target[:] = 1.0
    own = OwnLimit("own limit", 1, unit="m/s²")
    control.set_limits((*control.limits, OwnBound(bot), own))
    sole = bot.soles[0]
    control.set_contacts(
        [SixteenSidedSole(sole.name, sole.half_length, sole.half_width), OwnContact("right_sole")]
    )
    return control


def placed_contacts(bot):
    control = plain(bot)
    tilted = pin.SE3(pin.rpy.rpyToMatrix(0.3, -0.2, 1.0), np.array([0.02, -0.01, 0.05]))
    control.set_contacts(
        [
            sole_contact(bot, "left"),
            wbc.PointContact("right_sole", placement=pin.SE3.Identity(), motion_weight=3000.0),
            wbc.PointContact(hand(bot), placement=tilted, friction=0.2, max_force=20.0),
        ]
    )
    control.contacts[1].placement = tilted
    return control


def coupled(bot):
    control = plain(bot)
    first, second, *_, last = bot.joint_names
    control.add(JointCouplingTask(bot, {second: 1.0, last: -0.5}, 0.1, priority=0))
    control.add(JointCouplingTask(bot, {first: 2.0, second: 1.0, last: 1.0}, weight=30.0))
    return control


def self_collision(bot):
    control = plain(bot)
    control.set_limits((*control.limits, SelfCollisionLimit(bot, margin=0.0, detection=0.3)))
    return control


@pytest.mark.parametrize(
    "make", [plain, exact, of_own_classes, placed_contacts, coupled, self_collision]
)
def test_a_recorded_tick_is_solved_again_alone_to_the_same_torques(make):
    bot = robot("talos")
    control = make(bot)
    for seed in range(1 if make is self_collision else 3):
        state = standing_state(bot, seed)
        command = control.step(state)
        assert command.status is Status.OK, command.explanation
        words = command.source.packed_inputs(command, WORDS).copy()
        again = recorded_controller(bot, packed_text(words), packed_values(words))
        found = again.step(state)
        np.testing.assert_allclose(found.tau, command.tau, rtol=0.0, atol=1e-9)
        assert str(found.explain()) == str(command.explain())


@pytest.mark.parametrize("priorities", [(1, 2, 2, 3, 3, 3), (1, 2, 3, 4, 5, 6)])
def test_ticks_of_strict_priorities_are_solved_again_to_the_same_torques(priorities):
    bot = robot("talos")
    control = plain(bot)
    for task, priority in zip(control.tasks, priorities, strict=True):
        task.priority = priority
    for seed in range(3):
        state = standing_state(bot, seed)
        command = control.step(state)
        assert command.status is Status.OK, command.explanation
        words = command.source.packed_inputs(command, WORDS)
        again = recorded_controller(bot, packed_text(words), packed_values(words))
        np.testing.assert_allclose(again.step(state).tau, command.tau, rtol=0.0, atol=1e-9)


def test_what_a_tick_would_have_been_with_another_limit_can_be_asked():
    bot, state = robot("talos"), standing_state(robot("talos"), 1)
    control = plain(bot)
    command = control.step(state)
    words = command.source.packed_inputs(command, WORDS)
    again = recorded_controller(bot, packed_text(words), packed_values(words))
    again.set_limits((wbc.TorqueLimit(bot, scale=0.5), *again.limits[1:]))
    control.set_limits((wbc.TorqueLimit(bot, scale=0.5), *control.limits[1:]))
    np.testing.assert_allclose(again.step(state).tau, control.step(state).tau, atol=1e-6)


def test_a_tick_whose_inputs_are_missing_says_why():
    bot, state = robot("talos"), standing_state(robot("talos"), 1)
    command = plain(bot).step(state)
    few = command.source.packed_inputs(command, 60)
    with pytest.raises(WbcError, match="need more than the 60 numbers"):
        recorded_controller(bot, packed_text(few), packed_values(few))
    slow = wbc.WholeBodyController(bot, formulation=wbc.Formulation.REDUCED)
    command = slow.step(state)
    words = command.source.packed_inputs(command, 60)
    with pytest.raises(WbcError, match="Formulation"):
        recorded_controller(bot, packed_text(words), packed_values(words))
