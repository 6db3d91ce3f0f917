"""A foot that a blow knocks off the ground no longer carries the robot."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import wbc
from wbc.gait import (
    DcmPlanner,
    Feet,
    GaitCommand,
    GaitParameters,
    GaitStateMachine,
    Phase,
    Placement,
    Velocity,
)
from wbc.gait.lost_contact import LostContact

DT = 0.002
BOTH, LEFT, RIGHT = frozenset({"left", "right"}), frozenset({"left"}), frozenset({"right"})
NEITHER: frozenset[str] = frozenset()


@pytest.fixture(scope="module")
def gaits():
    robot = wbc.load("g1")
    gait = GaitParameters.for_robot(robot)
    return gait, GaitParameters.for_recovery(robot, gait)


class Walking:
    """A gait that walks on the spot, whose feet are where they are put."""

    def __init__(self, gaits) -> None:
        gait, recovery = gaits
        half = 0.5 * gait.step_width
        self.feet = Feet(Placement(complex(0.0, half), 0.0), Placement(complex(0.0, -half), 0.0))
        self.machine = GaitStateMachine(gait, self.feet, DcmPlanner(), recovery)
        self.state = self.machine.state
        self.command = GaitCommand(Velocity(0.1, 0.0, 0.0))

    def tick(self, contacts: frozenset[str] | None) -> None:
        self.machine.update(DT, self.feet, self.command, contacts)
        self.machine.move_swing(DT, self.state.landing)

    def walk_until(self, phase: Phase, support: str) -> None:
        """Walk with feet that follow their swing and touch when they are to."""
        state = self.state
        for _ in range(2000):
            if state.phase is phase and state.support == support and not state.starting:
                return
            swinging = state.phase is Phase.SWING
            landed = swinging and state.time + DT >= state.duration
            carrying = frozenset({state.support}) if swinging and not landed else BOTH
            self.tick(carrying)
            if state.swing is not None:
                x, y, z = state.swing.motion.position
                self.put(state.swing_side, Placement(complex(x, y), state.swing.yaw, z))
        raise AssertionError(f"no {phase.name} on the {support} foot")

    def put(self, side: str, place: Placement) -> None:
        self.feet = replace(self.feet, **{side: place})

    def knock(self, side: str, way: complex, up: float) -> None:
        place = self.feet.of(side)
        self.put(side, Placement(place.point + way, place.yaw, place.height + up))


def test_a_foot_that_the_weight_moves_to_and_that_is_knocked_away_steps_from_where_it_is(gaits):
    walking = Walking(gaits)
    walking.walk_until(Phase.TRANSFER, "left")
    walking.tick(BOTH)
    walking.knock("left", -0.06 + 0j, 0.08)
    knocked = walking.feet.left
    walking.tick(RIGHT)
    state = walking.state
    assert (state.phase, state.support, state.lost_foot) == (Phase.SWING, "right", "left")
    assert state.recovering
    assert state.shortened
    x, y, z = state.swing.motion.position
    assert abs(complex(x, y) - knocked.point) < 0.005
    assert z == pytest.approx(knocked.height, abs=0.005)
    for _ in range(round(state.duration / DT) - 1):
        walking.tick(RIGHT)
    assert state.swing.motion.position[2] < 0.01  # back on the ground when its time is over


def test_a_standing_foot_that_is_knocked_away_is_the_one_that_steps(gaits):
    walking = Walking(gaits)
    walking.command = GaitCommand()
    walking.tick(BOTH)
    walking.knock("right", 0.1 + 0j, 0.05)
    walking.tick(LEFT)
    assert walking.state.lost_foot == "right"


@pytest.mark.parametrize(
    ("way", "up", "contacts"),
    [
        (0.1 + 0j, 0.0, BOTH),  # it slips, and carries on
        (0.01j, 0.02, RIGHT),  # it bounces where it stands
        (0.1 + 0j, 0.1, NEITHER),  # the other one does not carry either
        (0.1 + 0j, 0.1, None),  # nobody measures it
    ],
)
def test_a_foot_that_slips_bounces_or_is_not_measured_is_not_lost(gaits, way, up, contacts):
    walking = Walking(gaits)
    walking.walk_until(Phase.TRANSFER, "left")
    lost = LostContact(walking.feet)
    walking.knock("left", way, up)
    walking.state.feet = walking.feet
    assert lost.update(walking.state, contacts, DT) is None
    walking.knock("left", 0.1j, 0.1)
    walking.state.feet = walking.feet
    assert lost.update(walking.state, RIGHT, DT) == "left"


def test_a_foot_that_bounces_while_the_whole_robot_seems_to_move_is_not_lost(gaits):
    walking = Walking(gaits)
    walking.walk_until(Phase.TRANSFER, "left")
    lost = LostContact(walking.feet)
    for side in ("left", "right"):
        walking.knock(side, 0.1 + 0.05j, 0.06)
    walking.state.feet = walking.feet
    assert lost.update(walking.state, RIGHT, DT) is None


def _fly(walking, lost, speed, *, quick=False):
    """Let the left foot go 6 cm ahead and 2 down as its step ends by time; return what is lost."""
    walking.walk_until(Phase.SWING, "right")
    state = walking.state
    lost.update(state, RIGHT, DT)
    state.phase, state.support, state.shortened = Phase.TRANSFER, "left", quick
    lost.begin_phase(walking.feet)
    found, ticks = None, round(math.hypot(0.06, 0.02) / (speed * DT))
    for _ in range(ticks):
        walking.knock("left", 0.06 / ticks + 0j, -0.02 / ticks)
        state.feet = walking.feet
        found = lost.update(state, RIGHT, DT)
    return found


def test_a_foot_that_is_late_and_still_on_its_way_down_is_not_lost(gaits):
    walking = Walking(gaits)
    lost, state = LostContact(walking.feet), walking.state
    assert _fly(walking, lost, 2.5) is None
    assert lost.update(state, BOTH, DT) is None
    walking.knock("left", 0.06 + 0j, 0.02)
    state.feet = walking.feet
    assert lost.update(state, RIGHT, DT) == "left"


def test_a_foot_that_a_blow_takes_along_as_it_lands_is_lost(gaits):
    walking = Walking(gaits)
    assert _fly(walking, LostContact(walking.feet), 4.0) == "left"


def test_a_foot_that_hurries_in_a_quick_step_is_not_lost(gaits):
    walking = Walking(gaits)
    assert _fly(walking, LostContact(walking.feet), 4.0, quick=True) is None


def test_a_foot_that_has_landed_takes_over_from_a_support_foot_that_is_knocked_away(gaits):
    walking = Walking(gaits)
    walking.walk_until(Phase.SWING, "left")
    state = walking.state
    while state.time < 0.1:
        walking.tick(LEFT)
    walking.put("right", walking.feet.right._replace(height=0.1))
    walking.knock("left", -0.1 + 0j, 0.1)
    walking.tick(NEITHER)
    assert (state.phase, state.support) == (Phase.SWING, "left")  # both are high: nothing to do
    steps = state.steps
    walking.tick(RIGHT)
    # The weight is on it already: the knocked one steps at once, from where it is.
    assert (state.phase, state.support, state.swing_side) == (Phase.SWING, "right", "left")
    assert state.steps == steps + 1
    assert state.shortened
    assert state.swing.motion.position[2] == pytest.approx(walking.feet.left.height, abs=0.005)


def test_a_foot_that_almost_has_landed_takes_over_and_the_knocked_one_steps(gaits):
    walking = Walking(gaits)
    walking.walk_until(Phase.SWING, "left")
    state = walking.state
    for _ in range(5):
        walking.tick(LEFT)
    walking.put("right", walking.feet.right._replace(height=0.02))
    walking.knock("left", -0.1 + 0j, 0.1)
    knocked = walking.feet.left
    walking.tick(NEITHER)
    assert (state.phase, state.support, state.swing_side) == (Phase.SWING, "right", "left")
    assert state.shortened
    assert state.swing.motion.position[2] == pytest.approx(knocked.height, abs=0.005)


def test_a_support_foot_that_is_still_landing_is_not_lost(gaits):
    walking = Walking(gaits)
    walking.walk_until(Phase.SWING, "right")
    state = walking.state

    def scuff(contacts):  # at 3 m/s, and stands nowhere
        walking.knock("left", 0.006 + 0j, 0.0)
        walking.tick(contacts)

    while (state.phase, state.support) != (Phase.SWING, "left"):
        scuff(BOTH)
    walking.put("right", walking.feet.right._replace(height=0.02))
    for contacts in (LEFT, NEITHER) * 20:
        scuff(contacts)
    assert (state.phase, state.support) == (Phase.SWING, "left")


def test_a_support_foot_that_has_slid_and_hops_is_not_lost(gaits):
    walking = Walking(gaits)
    walking.walk_until(Phase.SWING, "left")
    for _ in range(100):  # at 0.4 m/s
        walking.knock("left", 0.0008j, 0.0)
        walking.tick(LEFT)
    walking.put("right", walking.feet.right._replace(height=0.02))
    walking.tick(NEITHER)
    assert (walking.state.support, walking.state.lost_foot) == ("left", None)
    walking.knock("left", -0.06 + 0j, 0.0)
    walking.tick(NEITHER)
    assert walking.state.support == "right"


def test_a_foot_that_stood_is_lost_when_a_blow_takes_it_away_as_its_step_begins(gaits):
    walking = Walking(gaits)
    walking.walk_until(Phase.SWING, "left")
    walking.put("right", walking.feet.right._replace(height=0.02))
    walking.knock("left", -0.1 + 0j, 0.1)
    walking.tick(NEITHER)  # in this step it has not touched the ground once
    assert (walking.state.support, walking.state.swing_side) == ("right", "left")


def test_the_end_of_a_quick_swing_waits_for_a_foot_that_is_still_high(gaits):
    walking = Walking(gaits)
    walking.walk_until(Phase.SWING, "left")
    state = walking.state
    state.shortened, state.duration = True, state.time + 0.02
    steps = state.steps
    walking.put("right", walking.feet.right._replace(height=0.08))
    ended = None
    for k in range(60):
        walking.tick(LEFT)
        if state.steps > steps:
            ended = k * DT
            break
    assert ended == pytest.approx(0.02 + 0.06, abs=0.005)  # it does not wait for ever


def test_a_foot_that_was_knocked_up_is_on_no_stair(gaits):
    walking = Walking(gaits)
    walking.walk_until(Phase.SWING, "left")
    walking.knock("left", 0j, 0.2)
    for contacts in (frozenset(), RIGHT):
        walking.tick(contacts)
        assert not walking.state.on_stairs


@pytest.mark.parametrize("side", ["left", "right"])
def test_g1_stays_up_when_a_foot_is_knocked_from_under_it(side):
    pytest.importorskip("mujoco")
    robot = wbc.load("g1")
    plant = wbc.sim.Mujoco(robot, seed=3)
    estimator, walker = wbc.Estimator(robot), wbc.Walker(robot)
    impulse = robot.mass * np.array([-0.35, 0.0, 0.45])
    plant.schedule_push(0.2, impulse, duration=0.08, frame=f"{side}_ankle_roll_joint")
    expected, highest, lost = None, 0.0, False
    for _ in range(1000):
        command = walker.step(estimator.update(plant.measure(), acceleration=expected))
        expected = command.acceleration
        plant.step(command)
        highest = max(highest, walker.feet.of(side).height)
        lost = lost or walker.gait_state.lost_foot == side
    assert highest > 0.1
    assert lost
    assert not walker.falling_why
    assert plant.ground_truth().q[2] > 0.9 * robot.q_nominal[2]
