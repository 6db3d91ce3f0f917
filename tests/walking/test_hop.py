"""A robot that is pushed towards its support foot hops on it."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import wbc
from wbc.gait import Feet, GaitParameters, GaitState, Hop, Phase, Placement, SwingFoot
from wbc.gait.footsteps import lateral_sign
from wbc.runtime.loop import run
from wbc.sim import Mujoco
from wbc.walking import WalkerGains
from wbc.walking.stabilizer import SupportPolygon
from wbc.walking.stabilizer.hopping import Hopping

DT = 0.002  # s
SIDES = ("left", "right")
ACCELERATION = 100.0  # m/s², that a leg gives its foot

ROBOT = wbc.load("g1")
GAIT = GaitParameters.for_robot(ROBOT)
QUICK = GaitParameters.for_recovery(ROBOT, GAIT)


def standing_on(support: str, dcm: complex = 0j) -> GaitState:
    """A quick swing with 0.15 s left; the DCM is ahead and outwards of the support foot, m."""
    feet = Feet(Placement(0.12j, 0.0, 0.0), Placement(-0.12j, 0.0, 0.0))
    state = GaitState(GAIT, feet, QUICK, support=support, phase=Phase.SWING, shortened=True)
    state.time, state.duration = 0.05, 0.2
    state.swing = SwingFoot(state.other_foot, state.other_foot, 0.2, 0.05, 0.05)
    state.dcm = state.stance.to_world(complex(dcm.real, lateral_sign(support) * dcm.imag))
    state.com, state.com_height = state.stance.point, GAIT.com_height
    return state


def hopping() -> Hopping:
    return Hopping(ROBOT, SupportPolygon(ROBOT), ACCELERATION)


def begins(
    state: GaitState, tilt: float = 0.0, touching: str = "support", momentum: complex = 0j
) -> bool:
    contacts = frozenset({state.support if touching == "support" else touching})
    return hopping().begins(state, contacts, tilt, state.dcm, momentum)


@pytest.mark.parametrize("support", SIDES)
def test_it_hops_once_the_dcm_is_out_of_reach_of_the_step_after_the_present_one(support):
    assert not begins(standing_on(support, 0.1j))
    assert begins(standing_on(support, 0.3j))


@pytest.mark.parametrize("support", SIDES)
def test_a_push_away_from_the_support_foot_is_left_to_the_swing_foot(support):
    assert not begins(standing_on(support, -0.3j))


def test_a_push_that_leads_ahead_as_well_is_left_to_long_steps():
    assert not begins(standing_on("left", 0.3 + 0.3j))


def test_it_does_not_hop_while_nobody_pushes():
    state = standing_on("left", 0.3j)
    state.shortened = False
    assert not begins(state)


@pytest.mark.parametrize(
    "change",
    [
        {"phase": Phase.TRANSFER},
        {"crossing": 1.0},
        {"on_stairs": True},
        {"time": 0.18},  # the swing foot is about to land
        {"vertical_velocity": 0.5},
    ],
)
def test_it_does_not_hop_when_another_foot_or_nothing_carries(change):
    state = standing_on("left", 0.3j)
    for name, value in change.items():
        setattr(state, name, value)
    assert not begins(state)


@pytest.mark.parametrize("support", SIDES)
def test_a_body_that_turns_back_already_is_not_turned_on_by_the_leg_of_a_hop(support):
    state, outwards = standing_on(support, 0.3j), lateral_sign(support)
    assert begins(state, momentum=0.05j * outwards)
    assert begins(state, momentum=-0.005j * outwards)
    assert not begins(state, momentum=-0.05j * outwards)


def test_a_tilted_robot_does_not_hop():
    state = standing_on("left", 0.3j)
    assert begins(state, tilt=0.2)
    assert not begins(state, tilt=0.3)


def test_without_the_support_foot_on_the_ground_it_does_not_hop():
    state = standing_on("left", 0.3j)
    assert not begins(state, touching="right")
    assert not hopping().begins(state, None, 0.0, state.dcm, 0j)


def test_it_hops_once_until_the_quick_steps_are_over():
    state, decides = standing_on("left", 0.3j), hopping()
    contacts = frozenset({"left"})
    assert decides.begins(state, contacts, 0.0, state.dcm, 0j)
    assert not decides.begins(state, contacts, 0.0, state.dcm, 0j)
    state.shortened = False
    assert not decides.begins(state, contacts, 0.0, state.dcm, 0j)
    state.shortened = True
    assert decides.begins(state, contacts, 0.0, state.dcm, 0j)


@pytest.mark.parametrize("support", SIDES)
def test_the_foot_lands_beyond_the_dcm_that_will_be_there_then(support):
    state = standing_on(support, 0.1j)
    outwards = lateral_sign(support)
    state.com_velocity = 0.3j * outwards
    hop = Hop(state, 0.5)
    state.vertical_velocity = 0.5
    hop.update(state, frozenset({support}), DT)
    landing = state.stance.to_local(hopping().landing(state, hop).point)
    dcm_then = 0.1 + 0.3 * hop.remaining
    assert outwards * landing.imag == pytest.approx(dcm_then + 0.06 * ROBOT.com_height)


def test_the_foot_lands_no_farther_than_its_leg_throws_it():
    state = standing_on("left", 0.9j)
    hop = Hop(state, 0.5)
    way = abs(hopping().landing(state, hop).point - state.stance.point)
    # From rest to rest within the flight on a quintic: a = (10/√3) d / T².
    assert way * 10.0 / math.sqrt(3.0) / hop.flight**2 == pytest.approx(1.4 * ACCELERATION)


@pytest.mark.parametrize("support", SIDES)
def test_the_other_foot_is_thrown_to_the_other_side(support):
    state = standing_on(support, 0.3j)
    away = state.stance.to_local(hopping().away(state, Hop(state, 0.5)).point)
    assert lateral_sign(support) * away.imag < -0.5


@given(rise=st.floats(-0.02, 0.04), speed=st.floats(0.5, 1.5))
def test_the_flight_lasts_until_the_com_is_back_at_the_height_at_which_it_lands(rise, speed):
    state = standing_on("left", 0.3j)
    hop = Hop(state, 0.5)
    state.com_height, state.vertical_velocity = GAIT.com_height + rise, speed
    hop.update(state, frozenset({"left"}), DT)
    assert hop.flies
    T, g = hop.flight, GAIT.gravity
    height = state.com_height + speed * T - 0.5 * g * T * T
    assert height == pytest.approx(min(state.com_height, 0.97 * GAIT.com_height), abs=1e-9)


def test_a_leg_that_is_straight_or_too_slow_leaves_the_ground_as_well():
    straight, slow = standing_on("left", 0.3j), standing_on("left", 0.3j)
    straight.com_height *= 1.1
    hop = Hop(straight, 0.5)
    hop.update(straight, frozenset({"left"}), DT)
    assert hop.flies
    hop, ticks = Hop(slow, 0.5), 0
    while not hop.flies:
        hop.update(slow, frozenset({"left"}), DT)
        ticks += 1
    assert ticks * DT == pytest.approx(0.06, abs=1.5 * DT)


def fly(contact_from: float) -> tuple[float, Hop]:
    """Fly with contact from a time (s) on; returns when the hop is over, s, and the hop."""
    state = standing_on("left", 0.3j)
    hop = Hop(state, 0.5)
    state.vertical_velocity = 0.8
    hop.update(state, frozenset({"left"}), DT)
    time = 0.0
    while True:
        time += DT
        contacts = frozenset({"left"} if time >= contact_from else ())
        if hop.update(state, contacts, DT):
            return time, hop


def test_it_ends_with_contact_but_not_with_that_of_the_take_off():
    over, hop = fly(0.0)
    assert over == pytest.approx(0.5 * hop.flight, abs=1.5 * DT)
    over, hop = fly(0.9 * hop.flight)
    assert over == pytest.approx(0.9 * hop.flight, abs=1.5 * DT)


def test_without_contact_it_ends_soon_after_its_time():
    over, hop = fly(math.inf)
    assert over == pytest.approx(hop.flight + 0.06, abs=1.5 * DT)


@dataclasses.dataclass
class Pushed:
    """What became of a robot that was pushed.

    Attributes:
        survived: whether it is on its feet 2 s later.
        hops: number of hops.
        airborne: how long no foot was on the ground during hops, s.
        contacts_in_flight: contacts that the QP counted on while the foot flew.
    """

    survived: bool
    hops: int
    airborne: float
    contacts_in_flight: set[str]


def push_towards_the_left_foot(gains: WalkerGains) -> Pushed:
    """G1 walks and is pushed to the left by 0.9 N·s/kg as its right foot has just lifted."""
    robot = ROBOT
    walker = wbc.Walker(robot, DT, gains=gains)
    walker.velocity = (0.2, 0.0, 0.0)
    pushed_at: list[float] = []
    hops, airborne, in_flight, flew = 0, 0, set(), False
    with Mujoco(robot, dt=DT, seed=0) as plant:

        def before(time: float) -> None:
            nonlocal hops, airborne, flew
            state = walker.gait_state
            swings = state.phase is Phase.SWING and state.support == "left"
            if time > 1.5 and swings and 0.04 < state.time < 0.05 and not pushed_at:
                yaw = walker.heading
                across = np.array([-math.sin(yaw), math.cos(yaw), 0.0])
                plant.push(0.9 * robot.mass * across)
                pushed_at.append(time)
            flies = state.hop is not None and state.hop.flies
            hops += flies and not flew
            flew = flies
            if flies:
                in_flight.update(contact.name for contact in walker.controller.contacts)
                assert walker.telemetry.phase == "flight"
                assert not walker.contact_plan.support.size
                loads = [wrench[2] for wrench in plant.foot_forces.values()]
                airborne += max(loads) < 1.0

        report = run(walker, plant, 5.0, before_tick=before)
    assert pushed_at
    return Pushed(report.survived, hops, airborne * DT, in_flight)


def test_a_push_towards_the_support_foot_is_survived_by_a_hop_and_not_without():
    hopping = push_towards_the_left_foot(WalkerGains.for_robot(ROBOT))
    assert hopping.survived
    assert hopping.hops == 1
    assert hopping.airborne > 0.05
    assert not hopping.contacts_in_flight
    without = dataclasses.replace(WalkerGains.for_robot(ROBOT), hop_speed=0.0)
    stepping = push_towards_the_left_foot(without)
    assert stepping.hops == 0
    assert not stepping.survived
