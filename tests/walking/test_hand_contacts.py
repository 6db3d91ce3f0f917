"""Forces on hands: where they move the pivot of the pendulum, and what the controller does."""

from __future__ import annotations

import copy

import numpy as np
import pinocchio as pin
import pytest
from coretools import robot

import wbc
from wbc.errors import ContactError
from wbc.geometry.polygon import clamp_to_polygon
from wbc.qp import Formulation
from wbc.robot.upper_body import UpperBody
from wbc.walking.hand_contacts import HandContact, HandContacts, axes_about


@pytest.mark.parametrize("normal", [(-1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.3, -0.5, -0.8)])
def test_the_axes_about_a_normal_are_a_rotation_with_level_x(normal):
    axes = axes_about(np.array(normal))
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    np.testing.assert_allclose(axes[:, 2], normal / np.linalg.norm(normal))
    assert axes[2, 0] == pytest.approx(0.0)


@pytest.mark.parametrize("normal", [np.zeros(3), np.array([np.nan, 0.0, 1.0]), np.ones(2)])
def test_a_normal_without_a_direction_is_refused(normal):
    with pytest.raises(ContactError, match="three finite numbers, not zero"):
        HandContact("left_hand", normal)


@pytest.mark.parametrize("seed", range(3))
def test_the_offset_is_what_balances_the_moments_about_the_zmp(seed):
    rng = np.random.default_rng(seed)
    bot = robot("simple_humanoid")
    kin = wbc.Kinematics(bot, bot.standing())
    arm = UpperBody.of(bot).arm("left")
    hands = HandContacts(bot)
    hand = hands.add(HandContact(arm.hand, rng.normal(size=3), point=rng.normal(size=3) * 0.1))
    hand.set_force(40.0, 40.0)
    hands.update(kin, 0.0)
    assert hands.known
    assert not hands.extension
    force, at = 40.0 * hand.normal, kin.frame(arm.hand).act(hand.contact.placement.translation)
    # At rest the pivot is below the CoM, and the soles' force, what is left, acts at the ZMP.
    c = kin.p_com
    weight = np.array([0.0, 0.0, -bot.weight])
    below = np.array([c[0], c[1], 0.0])
    moment = np.cross(at - below, force)
    sole = -weight - force
    shift = np.array([moment[1], -moment[0]]) / sole[2]  # p − c, from moments about `below`
    # The pendulum takes the weight for the force at the ZMP, so offsets agree in first order.
    expected = -shift * sole[2] / bot.weight
    assert hands.offset == pytest.approx(complex(*expected), abs=1e-12)


def test_forces_to_choose_from_enlarge_the_area_of_the_pivot():
    bot = robot("simple_humanoid")
    kin = wbc.Kinematics(bot, bot.standing())
    walker = wbc.Walker(bot)
    hand = HandContact(UpperBody.of(bot).arm("left").hand, np.array([-1.0, 0.0, 0.0]))
    walker.hand_contacts.add(hand)
    hand.set_force(10.0, 80.0)
    walker.hand_contacts.update(kin, 0.0)
    support = walker.stabilizer.support
    before = support.hull(walker.feet)
    support.extension = walker.hand_contacts.extension
    after = support.hull(walker.feet)
    toes = max(corner.real for corner in before)
    height = kin.frame(hand.contact.frame).translation[2]
    gained = max(corner.real for corner in after) - toes
    assert gained >= 70.0 * height / bot.weight
    assert all(clamp_to_polygon(corner, after, 1e-9) == corner for corner in before)


@pytest.mark.parametrize("formulation", list(Formulation), ids=lambda f: f.name)
def test_a_known_force_on_a_hand_is_borne_by_the_arm_and_the_soles(formulation):
    bot = robot("talos")
    frame = UpperBody.of(bot).arm("left").hand
    controller = wbc.WholeBodyController(bot, formulation=formulation)
    controller.add(wbc.ComTask(weight=1000.0))
    controller.add(wbc.PostureTask(bot))
    hand = HandContact(frame, np.array([0.3, 0.2, -1.0]), friction=1e-3, motion_weight=1e-6)
    hand.set_force(15.0, 15.0)
    soles = [wbc.SurfaceContact.from_sole(sole) for sole in bot.soles]
    soles[1].motion_weight = 3000.0
    controller.set_contacts([*soles, hand.contact])
    state = bot.standing()
    kin = wbc.Kinematics(bot, state)
    hand.place(kin)
    command = controller.step(state)
    assert command.status is wbc.Status.OK
    # Newton and Euler: what the command says about forces and motion satisfies the dynamics.
    left = kin.mass_matrix @ command.acceleration + kin.bias_forces
    left[6:] -= command.tau
    for sole in bot.soles:
        left -= kin.motion_local(sole.frame_id).jacobian.T @ command.wrenches[sole.name]
    force = 15.0 * hand.normal
    left -= kin.jacobian(frame)[:3].T @ force
    np.testing.assert_allclose(left, 0.0, atol=0.05)


def test_a_placement_moves_the_rows_of_a_contact_to_another_point_and_axes():
    bot = robot("g1")
    rng = np.random.default_rng(0)
    q = pin.integrate(bot.model, bot.q_nominal, 0.3 * rng.normal(size=bot.nv))
    kin = wbc.Kinematics(bot, wbc.State(q, rng.normal(size=bot.nv)))
    placement = pin.SE3.Random()
    sole = bot.soles[0]
    contact = wbc.SurfaceContact(sole.name, 0.1, 0.05, placement=placement, damping=0.0)
    contact.bind(bot)
    J, a = np.empty((6, bot.nv)), np.empty(6)
    contact.write(kin, J, a)
    model = bot.model.copy()
    parent = model.frames[bot.frame_id(sole.name)]
    added = pin.Frame(
        "placed", parent.parentJoint, parent.placement * placement, pin.FrameType.OP_FRAME
    )
    model.addFrame(added)
    data = model.createData()
    pin.forwardKinematics(model, data, q, kin.state.v, np.zeros(bot.nv))
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    frame, axes = model.getFrameId("placed"), pin.ReferenceFrame.LOCAL
    np.testing.assert_allclose(J, pin.getFrameJacobian(model, data, frame, axes), atol=1e-12)
    bias = pin.getFrameClassicalAcceleration(model, data, frame, axes).vector
    np.testing.assert_allclose(a, -bias, atol=1e-10)


def test_a_walker_that_carries_something_goes_on_identically_as_a_copy():
    bot = robot("simple_humanoid")
    walker = wbc.Walker(bot)
    hand = HandContact(UpperBody.of(bot).arm("left").hand, np.array([0.0, 0.0, -1.0]))
    walker.hand_contacts.add(hand)
    hand.set_force(20.0, 20.0)
    estimate = wbc.estimation.Estimate(bot.standing())
    walker.step(estimate)
    other = copy.deepcopy(walker)
    for _ in range(3):
        np.testing.assert_array_equal(walker.step(estimate).tau, other.step(estimate).tau)
    with pytest.raises(ContactError, match="there is a hand contact"):
        walker.hand_contacts.add(hand)
    walker.hand_contacts.remove(hand)
    walker.step(estimate)
    assert all("hand" not in contact.name for contact in walker.controller.contacts)
