"""How the feet on the ground are held, and how much they may carry."""

import math
from typing import NamedTuple

import numpy as np
import pytest

import wbc
from wbc.contacts import Contact, EdgeContact
from wbc.gait import Feet, GaitParameters, GaitState, Phase, Placement, SwingFoot
from wbc.walking.contact_manager import ContactManager
from wbc.walking.gains import WalkerGains
from wbc.walking.hand_contacts import HandContacts


class OneLegged(NamedTuple):
    """A robot on its left foot."""

    robot: wbc.Robot
    state: GaitState
    manager: ContactManager
    controller: wbc.WholeBodyController

    def support(
        self, touching: frozenset[str] | None = frozenset({"left"}), speed: float = 0.0
    ) -> Contact:
        """Return the contact of the support foot, which has a speed, at this tick."""
        self.manager.update(self.state, touching, (speed, 0.0))
        (contact,) = self.controller.contacts
        return contact


@pytest.fixture
def one_legged() -> OneLegged:
    robot = wbc.load("g1")
    kin, gait = wbc.Kinematics(robot, robot.standing()), GaitParameters.for_robot(robot)
    places = (kin.frame(sole.name).translation for sole in robot.soles)
    feet = Feet(*(Placement(complex(*p[:2]), 0.0, float(p[2])) for p in places))
    state = GaitState(gait, feet, GaitParameters.for_recovery(robot, gait))
    state.phase, state.support, state.duration = Phase.SWING, "left", gait.single_support
    controller = wbc.WholeBodyController(robot)
    manager = ContactManager(robot, controller, WalkerGains(), HandContacts(robot))
    return OneLegged(robot, state, manager, controller)


def test_the_support_foot_of_a_usual_step_is_held_exactly_whatever_it_carries(one_legged):
    one_legged.state.vertical_velocity = 1.0
    support = one_legged.support()
    assert support.motion_weight is None
    assert support.max_force == math.inf


def test_that_of_a_quick_step_gives_way_where_everything_else_would_have_to(one_legged):
    one_legged.state.shortened = True
    support = one_legged.support()
    assert support.motion_weight == WalkerGains().second_contact_weight
    assert support.max_force == math.inf
    one_legged.state.shortened = False
    assert one_legged.support().motion_weight is None


def test_a_swing_foot_that_a_blow_has_thrown_off_its_way_leaves_the_support_foot_where_it_is(
    one_legged,
):
    state = one_legged.state
    place = state.other_foot
    swing = state.swing = SwingFoot(place, place, state.duration, 0.05, 0.1)
    state.shortened = True
    assert one_legged.support().motion_weight is not None
    swing.follow(np.array((0.0, -0.2, 0.3)), np.array((0.0, 0.0, 3.0)), np.zeros(3))
    assert one_legged.support().motion_weight is None
    in_the_air = one_legged.support(touching=frozenset())
    assert in_the_air.motion_weight == WalkerGains().second_contact_weight
    bouncing = one_legged.support(speed=1.0)
    assert bouncing.motion_weight == WalkerGains().second_contact_weight


def test_a_sole_that_tips_in_a_quick_step_is_held_exactly_by_its_edge(one_legged):
    state = one_legged.state
    state.shortened, state.tipping = True, 1j
    edge = one_legged.support()
    assert isinstance(edge, EdgeContact)
    assert edge.motion_weight is None


def test_in_the_air_it_is_held_as_a_whole_and_gives_way(one_legged):
    state = one_legged.state
    state.shortened, state.tipping = True, 1j
    for touching in (frozenset(), frozenset({"right"})):
        support = one_legged.support(touching)
        assert not isinstance(support, EdgeContact)
        assert support.motion_weight == WalkerGains().second_contact_weight
    assert isinstance(one_legged.support(touching=None), EdgeContact)  # without foot sensors


def test_while_it_bounces_after_a_blow_it_is_held_as_a_whole_and_gives_way(one_legged):
    state = one_legged.state
    state.shortened, state.tipping = True, 1j
    assert isinstance(one_legged.support(speed=1.0), EdgeContact)  # it tips over the edge fast
    place = state.other_foot
    swing = state.swing = SwingFoot(place, place, state.duration, 0.05, 0.1)
    swing.follow(np.array((0.0, -0.2, 0.3)), np.array((0.0, 0.0, 3.0)), np.zeros(3))
    bouncing = one_legged.support(speed=1.0)
    assert not isinstance(bouncing, EdgeContact)
    assert bouncing.motion_weight == WalkerGains().second_contact_weight
    assert isinstance(one_legged.support(speed=0.3), EdgeContact)


@pytest.mark.parametrize(("velocity", "share"), [(1.0, 1.0), (0.0, math.inf), (-1.0, math.inf)])
def test_in_a_quick_step_it_does_not_press_a_robot_up_that_a_blow_throws_up(
    one_legged, velocity, share
):
    state, robot = one_legged.state, one_legged.robot
    state.shortened, state.vertical_velocity = True, velocity
    assert one_legged.support().max_force == share * robot.weight
    # The body turns about the vertical: friction holds it, the more the more the foot is pressed.
    moving = robot.standing()
    moving.v[2], moving.v[5] = velocity, 6.0
    one_legged.controller.add(wbc.OrientationTask(robot.base, weight=100.0, kp=400.0))
    one_legged.controller.add(wbc.PostureTask(robot))
    command = one_legged.controller.solve(wbc.Kinematics(robot, moving))
    assert command.status is wbc.Status.OK
    (force,) = (np.asarray(wrench)[2] for wrench in command.wrenches.values())
    if velocity > 0.0:
        assert force <= robot.weight * (1.0 + 1e-6)
    else:
        assert force > robot.weight
