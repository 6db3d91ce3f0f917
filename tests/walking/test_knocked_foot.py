"""A blow throws a foot off its way, or into the air: its reference goes on with its motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

import wbc
from wbc.gait import Feet, GaitParameters, GaitState, Phase, Placement, SwingFoot
from wbc.walking.ground_kinematics import GroundKinematics
from wbc.walking.knocked_foot import KnockedFoot

LEFT = frozenset({"left"})


@dataclass
class OneLegged:
    """G1 on its left leg; the right foot moves at a velocity, its reference at another one."""

    robot: wbc.Robot
    kin: wbc.Kinematics
    state: GaitState
    knocked_foot: KnockedFoot

    @property
    def swing(self) -> SwingFoot:
        swing = self.state.swing
        assert isinstance(swing, SwingFoot)
        return swing

    def move(self, foot: list[float], reference: list[float]) -> None:
        sole = self.robot.soles[1]
        leg = np.array(self.robot.legs[1])
        jacobian = self.kin.motion(sole.name).jacobian[:3, leg]
        v = np.zeros(self.robot.nv)
        v[leg] = np.linalg.pinv(jacobian) @ foot
        self.kin.update(wbc.State(self.robot.q_nominal, v))
        self.swing.motion.position[:] = self.kin.motion(sole.name).position
        self.swing.motion.velocity[:3] = reference

    def update(self, contacts: frozenset[str] | None = LEFT) -> bool:
        ground = GroundKinematics(self.robot, self.kin)
        ground.read()
        self.knocked_foot.update(self.state, self.kin, ground.speeds, contacts)
        return self.swing.knocked


@pytest.fixture
def one_legged() -> OneLegged:
    robot = wbc.load("g1")
    gait = GaitParameters.for_robot(robot)
    kin = wbc.Kinematics(robot, robot.standing())
    left, right = (kin.frame(sole.name).translation for sole in robot.soles)
    feet = Feet(*(Placement(complex(*p[:2]), 0.0, float(p[2])) for p in (left, right)))
    state = GaitState(gait, feet, GaitParameters.for_recovery(robot, gait))
    state.phase, state.support = Phase.SWING, "left"
    state.time, state.duration, state.landing = 0.2, gait.single_support, feet.right
    state.swing = SwingFoot(feet.right, feet.right, state.duration, 0.05, 0.05)
    walker = wbc.Walker(robot)
    tasks = walker.tasks[-len(robot.soles) :]
    acceleration = walker.stabilizer.push_recovery.foot_acceleration
    return OneLegged(robot, kin, state, KnockedFoot(robot, tasks, acceleration))


@pytest.mark.parametrize("direction", [(1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, 0, 1)])
def test_a_foot_much_faster_than_its_reference_is_followed_in_a_quick_step(one_legged, direction):
    velocity = 5.0 * np.array(direction, dtype=float)
    one_legged.move(list(velocity), [0.0, 0.0, 0.0])
    assert one_legged.update()
    motion = one_legged.swing.motion
    assert motion.velocity[:3] == pytest.approx(velocity, abs=1e-9)
    assert one_legged.state.is_quick
    # It brakes twice as hard as the leg can for long, 8 g of G1, against its way.
    assert motion.acceleration[:3] @ direction == pytest.approx(-2.0 * 8.2 * 9.81, rel=0.05)


def test_a_foot_that_lags_behind_its_reference_is_not_taken_for_knocked(one_legged):
    one_legged.move([0.0, 0.0, 0.0], [5.0, 0.0, 0.0])
    assert not one_legged.update()
    assert one_legged.swing.motion.velocity[0] == 5.0
    assert not one_legged.state.is_quick


def test_a_foot_far_above_its_reference_is_followed_though_it_is_not_fast(one_legged):
    one_legged.move([0.0, 0.0, 1.0], [0.0, 0.0, 0.0])
    one_legged.swing.motion.position[2] -= 0.06
    assert not one_legged.update()
    one_legged.swing.motion.position[2] -= 0.06
    assert one_legged.update()
    motion, place = one_legged.swing.motion, one_legged.state.other_foot
    assert motion.position[2] == pytest.approx(place.height, abs=1e-9)
    assert motion.velocity[:3] == pytest.approx([0.0, 0.0, 1.0], abs=1e-9)


def test_a_foot_far_below_its_reference_hurries_after_it(one_legged):
    one_legged.move([0.0, 0.0, -1.0], [0.0, 0.0, 0.0])
    one_legged.swing.motion.position[2] += 0.3
    assert not one_legged.update()


def test_a_foot_that_follows_a_fast_reference_is_not_taken_for_knocked(one_legged):
    one_legged.move([5.0, 0.0, 0.0], [4.0, 0.0, 0.0])
    assert not one_legged.update()


@pytest.mark.parametrize("contacts", [None, frozenset(), frozenset({"right"})])
def test_without_a_support_foot_on_the_ground_no_foot_is_followed(one_legged, contacts):
    one_legged.move([5.0, 0.0, 0.0], [0.0, 0.0, 0.0])
    assert not one_legged.update(contacts)


def test_a_foot_that_is_about_to_land_is_left_alone(one_legged):
    one_legged.move([5.0, 0.0, 0.0], [0.0, 0.0, 0.0])
    one_legged.state.time = one_legged.state.duration - 0.01
    assert not one_legged.update()


def test_the_step_of_a_knocked_foot_lasts_until_the_foot_gets_to_its_place(one_legged):
    one_legged.state.time = one_legged.state.duration - 0.05
    one_legged.move([5.0, 0.0, 0.0], [0.0, 0.0, 0.0])
    assert one_legged.update()
    assert one_legged.state.remaining >= 0.1 - 1e-9


@pytest.mark.parametrize("contacts", [frozenset(), LEFT])
def test_a_quick_swing_of_a_foot_in_the_air_begins_with_the_foot_s_velocity(one_legged, contacts):
    one_legged.state.time, one_legged.state.shortened = 0.0, True
    one_legged.move([1.0, -1.5, 0.5], [0.0, 0.0, 0.0])
    assert not one_legged.update(contacts)
    assert one_legged.swing.motion.velocity[:3] == pytest.approx([1.0, -1.5, 0.0], abs=1e-9)
    before = one_legged.swing.motion.position.copy()
    one_legged.swing.advance(0.002, one_legged.state.landing)
    moved = one_legged.swing.motion.position[:2] - before[:2]
    assert moved == pytest.approx([0.002, -0.003], rel=0.1)  # it does not wait to lift off


@pytest.mark.parametrize(
    ("contacts", "time", "shortened"),
    [
        (None, 0.0, True),
        (frozenset({"left", "right"}), 0.0, True),
        (frozenset(), 0.002, True),
        (frozenset(), 0.0, False),
    ],
    ids=["no sensors", "on the ground", "later", "usual step"],
)
def test_other_swings_do_not_begin_with_the_foot_s_velocity(one_legged, contacts, time, shortened):
    one_legged.state.time, one_legged.state.shortened = time, shortened
    one_legged.move([1.0, -1.5, 0.0], [0.0, 0.0, 0.0])
    assert not one_legged.update(contacts)
    assert (one_legged.swing.motion.velocity[:3] == 0.0).all()
