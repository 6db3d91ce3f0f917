"""Step adjustment, the legs' reach, and the gait's state machine."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import wbc
from wbc.gait import Feet, GaitParameters, GaitStateMachine, Phase, Placement, Velocity, solve_dcm
from wbc.gait.footstep_preview import FootstepPreview, zmp_over
from wbc.gait.leg_workspace import LegWorkspace
from wbc.walking.stabilizer import footstep_adjustment

OMEGA, REACH = 3.4, (0.07, 0.04)
errors = st.floats(-0.15, 0.15)
times = st.floats(0.0, 0.6)


@given(errors, errors, times)
def test_shift_makes_up_for_what_the_ankles_cannot(x: float, y: float, remaining: float) -> None:
    shift = footstep_adjustment(complex(x, y), OMEGA, remaining, REACH)
    for error, reach, moved in ((x, REACH[0], shift.real), (y, REACH[1], shift.imag)):
        # The pendulum's error under the strongest push-back of the ankle, e' = ω (e − m).
        growth = math.exp(OMEGA * remaining)
        left = abs(error) * growth - reach * (growth - 1.0)
        assert abs(moved) == pytest.approx(max(left, 0.0), abs=1e-12)
        assert moved * error >= 0.0


@given(st.floats(0.05, 0.6))
def test_errors_that_the_ankles_catch_leave_the_footstep_alone(remaining: float) -> None:
    caught = 0.99 * REACH[1] * (1.0 - math.exp(-OMEGA * remaining))
    assert footstep_adjustment(complex(0.0, caught), OMEGA, remaining, REACH) == 0j


@pytest.mark.parametrize(
    ("name", "knees"),
    [
        ("talos", ("leg_left_4_joint", "leg_right_4_joint")),
        ("g1", ("left_knee_joint", "right_knee_joint")),
        ("romeo", ("LKneePitch", "RKneePitch")),
        ("simple_humanoid", ("left_knee", "right_knee")),
    ],
)
def test_knees_are_found_and_long_steps_lower_the_body(name: str, knees: tuple[str, str]) -> None:
    robot = wbc.load(name)
    reach = LegWorkspace(robot)
    assert tuple(robot.joint_names[k] for k in reach.knees) == knees
    heights = [reach.com_height(step) for step in np.linspace(0.0, 0.5 * robot.leg_length, 12)]
    assert all(low <= high + 1e-12 for high, low in itertools.pairwise(heights))
    assert heights[0] <= robot.com_height + 1e-12
    assert 0.7 * robot.com_height < heights[-1] < heights[0]


def test_knees_that_carry_little_more_than_the_robot_allow_only_short_steps() -> None:
    romeo, talos = wbc.load("romeo"), wbc.load("talos")
    assert GaitParameters.for_robot(romeo).max_step < 0.3 * romeo.leg_length
    assert GaitParameters.for_robot(talos).max_step == pytest.approx(0.51 * talos.com_height)


def test_reach_is_the_distance_from_hip_to_ankle_with_a_bent_knee() -> None:
    robot = wbc.load("simple_humanoid")
    data = robot.model.createData()
    q = robot.q_nominal.copy()
    q[7 + robot.joint_index("left_knee")] = 0.6  # straight is 0
    pin.forwardKinematics(robot.model, data, q)
    hip = data.oMi[robot.model.getJointId("left_hip_yaw")].translation
    ankle = data.oMi[robot.model.getJointId("left_ankle_roll")].translation
    assert LegWorkspace(robot).reach == pytest.approx(float(np.linalg.norm(hip - ankle)), abs=0.01)


GAIT = GaitParameters.for_robot(wbc.load("talos"))
DT = 0.002
HALF = 0.5 * GAIT.step_width
SQUARE = Feet(Placement(complex(0.0, HALF), 0.0), Placement(complex(0.0, -HALF), 0.0))
WALK = Velocity(0.3, 0.0, 0.0)


class Ground:
    """Feet that follow the gait's swing exactly; contact when told."""

    def __init__(self, feet: Feet = SQUARE) -> None:
        self.feet = feet
        self.state_machine = GaitStateMachine(GAIT, feet)

    def run(self, duration: float, velocity: Velocity, contacts: set[str] | None) -> None:
        state_machine = self.state_machine
        for _ in range(round(duration / DT)):
            state_machine.update(DT, self.feet, velocity, contacts)
            if state_machine.swing is not None:
                x, y, z = state_machine.swing.position
                placed = Placement(complex(x, y), state_machine.swing.yaw, z)
                if state_machine.swing_side == "left":
                    self.feet = Feet(placed, self.feet.right)
                else:
                    self.feet = Feet(self.feet.left, placed)


def test_nothing_happens_without_a_command() -> None:
    ground = Ground()
    ground.run(1.0, Velocity(), None)
    assert ground.state_machine.phase is Phase.STAND
    assert ground.state_machine.preview() == []
    assert ground.state_machine.reference().zmp == pytest.approx(0j)
    assert ground.state_machine.reference().dcm_velocity == 0j


def test_feet_alternate_and_a_stop_ends_with_both_side_by_side() -> None:
    ground = Ground()
    ground.run(3.0, WALK, None)
    assert ground.state_machine.steps >= 3
    ground.run(3.0, Velocity(), None)
    state_machine, feet = ground.state_machine, ground.feet
    assert state_machine.phase is Phase.STAND
    apart = feet.left.to_local(feet.right.point)
    assert apart.real == pytest.approx(0.0, abs=1e-3)
    assert -apart.imag == pytest.approx(GAIT.step_width, abs=1e-3)


def test_swing_ends_early_when_the_foot_meets_the_ground() -> None:
    ground = Ground()
    ground.run(GAIT.first_transfer + 0.8 * GAIT.single_support, WALK, {"left"})
    assert ground.state_machine.phase is Phase.SWING
    ground.run(DT, WALK, {"left", "right"})
    assert ground.state_machine.phase is Phase.TRANSFER
    # The plan keeps its time: what the swing saved is added to the transfer.
    saved = 0.2 * GAIT.single_support
    assert ground.state_machine.duration == pytest.approx(GAIT.double_support + saved, abs=3 * DT)


def test_load_on_a_foot_that_just_left_is_not_a_landing() -> None:
    ground = Ground()
    ground.run(GAIT.first_transfer + 0.1 * GAIT.single_support, WALK, {"left"})
    ground.run(0.1 * GAIT.single_support, WALK, {"left", "right"})
    assert ground.state_machine.phase is Phase.SWING


def test_swing_goes_on_until_the_ground_is_found() -> None:
    ground = Ground()
    one_foot = {"left"}
    ground.run(GAIT.first_transfer + GAIT.single_support + 0.1, WALK, one_foot)
    assert ground.state_machine.phase is Phase.SWING
    assert ground.feet.right.height < -0.01
    ground.run(DT, WALK, {"left", "right"})
    assert ground.state_machine.phase is Phase.TRANSFER


def test_plan_ends_at_rest_between_the_last_two_feet() -> None:
    ground = Ground()
    ground.run(1.0, WALK, None)
    places = [step.point for _, step in ground.state_machine.preview()]
    segments = zmp_over(ground.feet.of(ground.state_machine.support).point, places, GAIT)
    assert segments[-1].end == pytest.approx(0.5 * (places[-2] + places[-1]))
    for one, following in itertools.pairwise(segments):
        assert one.end == pytest.approx(following.start)  # the ZMP never jumps


def test_planned_dcm_moves_with_its_own_velocity_from_phase_to_phase() -> None:
    ground = Ground()
    before, phases = ground.state_machine.reference(), set()
    for tick in range(round(6.0 / DT)):
        ground.run(DT, WALK if 0.1 < tick * DT < 3.0 else Velocity(), None)
        now = ground.state_machine.reference()
        # Beginning, going on and stopping change what is wanted: the plan may jump then.
        if 0.2 < tick * DT < 2.9:
            assert abs(now.dcm - before.dcm - DT * before.dcm_velocity) < 1e-3
            assert abs(now.zmp - before.zmp) < 0.01
        before = now
        phases.add(ground.state_machine.phase)
    assert phases == set(Phase)
    assert before.dcm == pytest.approx(ground.feet.middle, abs=1e-6)


@given(
    st.floats(0.1, 2.5),
    st.builds(Velocity, st.floats(-0.3, 0.5), st.floats(-0.1, 0.1), st.floats(-0.3, 0.3)),
)
@settings(max_examples=25)
def test_another_velocity_takes_effect_within_the_step_and_without_a_jump(
    when: float, wanted: Velocity
) -> None:
    ground = Ground()
    ground.run(when, WALK, None)
    state_machine = ground.state_machine
    for tick in range(round(0.6 / DT)):
        before, steps, landing = (
            state_machine.reference(),
            state_machine.steps,
            state_machine.target.point,
        )
        swings = state_machine.phase is Phase.SWING
        ground.run(DT, wanted, None)
        if tick == 3 and wanted != WALK:
            assert state_machine.velocity != WALK
        if state_machine.steps > steps:  # what is left of the change is for the next step
            break
        now = state_machine.reference()
        assert abs(now.dcm - before.dcm - DT * before.dcm_velocity) < 1e-3
        if swings:
            assert abs(state_machine.target.point - landing) < 1.5 * DT  # 1.5 m/s


def test_a_wish_that_jumps_about_from_tick_to_tick_does_not_shake_the_plan() -> None:
    ground, rng, asked = Ground(), np.random.default_rng(0), []
    ground.run(1.0, WALK, None)
    for _ in range(round(2.0 / DT)):
        ground.run(DT, Velocity(*(WALK.forward + 0.1 * rng.normal(size=3)).tolist()), None)
        now = ground.state_machine.reference()
        asked.append(now.dcm - now.dcm_velocity / GAIT.omega - now.zmp)  # beyond the plan's ZMP
    assert np.abs(asked).max() > 2e-3
    assert np.percentile(np.abs(np.diff(asked)), 99) < 6e-3


def test_a_wish_to_stop_shortens_the_present_step_and_the_next_one_is_the_last() -> None:
    stopped, went_on = Ground(), Ground()
    for ground, wanted in ((stopped, Velocity()), (went_on, WALK)):
        ground.run(GAIT.first_transfer + 0.1 * GAIT.single_support, WALK, None)
        ground.run(0.4 * GAIT.single_support, wanted, None)
    assert stopped.state_machine.target.point.real < went_on.state_machine.target.point.real - 0.02
    assert len(stopped.state_machine.preview()) > 1
    stopped.run(0.6 * GAIT.single_support, Velocity(), None)
    stopped.run(GAIT.step_duration + GAIT.first_transfer, Velocity(), None)
    assert stopped.state_machine.steps == 2
    assert stopped.state_machine.phase is Phase.STAND


def test_a_higher_swing_counts_for_a_foot_on_its_way_up() -> None:
    ground = Ground()
    ground.run(GAIT.first_transfer + 0.2 * GAIT.single_support, WALK, None)
    ground.state_machine.change_gait(replace(GAIT, swing_height=2.0 * GAIT.swing_height))
    ground.run(0.3 * GAIT.single_support, WALK, None)
    assert ground.feet.right.height == pytest.approx(2.0 * GAIT.swing_height, rel=0.02)


velocities = st.builds(
    Velocity,
    st.sampled_from([0.0, -0.2, 0.4]),
    st.sampled_from([0.0, 0.1]),
    st.sampled_from([0.0, -0.3]),
)
feet = st.builds(Placement, st.builds(complex, errors, errors), st.floats(-3.0, 3.0))


@given(st.lists(st.tuples(feet, velocities, st.sampled_from(["left", "right"])), max_size=4))
def test_arrival_dcm_known_in_the_foots_axes_is_that_of_the_steps_in_the_world(
    asked: list[tuple[Placement, Velocity, str]],
) -> None:
    preview = FootstepPreview(GAIT, [])
    for foot, velocity, side in asked:
        steps = preview.steps(foot, side, velocity, 3)
        assert len(steps) == (1 if velocity.is_zero else 3)
        segments = zmp_over(foot.point, [step.point for _, step in steps], GAIT)
        expected = solve_dcm(segments, GAIT.omega).dcm
        assert preview.arrival_dcm(foot, side, velocity, 3) == pytest.approx(expected, abs=1e-12)


def test_given_footsteps_stay_in_the_world_when_the_foot_is_measured_elsewhere() -> None:
    queue = [("right", Placement(0.2 - HALF * 1j, 0.0)), ("left", Placement(0.2 + HALF * 1j, 0.0))]
    preview = FootstepPreview(GAIT, queue)
    for x in (0.0, 0.01):
        steps = preview.steps(Placement(complex(x, HALF), 0.0), "left", Velocity(), 3)
        assert [step.point for _, step in steps] == pytest.approx([p.point for _, p in queue])


def test_shift_moves_the_landing_but_not_the_plan_without_it() -> None:
    ground = Ground()
    ground.run(GAIT.first_transfer + 0.3 * GAIT.single_support, WALK, None)
    state_machine = ground.state_machine
    planned = state_machine.landing.planned
    state_machine.landing.adjustment = complex(0.05, -0.03)
    assert state_machine.landing.planned == planned
    assert state_machine.target.point - planned.point == pytest.approx(complex(0.05, -0.03))
    state_machine.landing.adjustment = complex(0.0, 1.0)  # through the other leg
    apart = SQUARE.left.to_local(state_machine.target.point)
    assert -apart.imag == pytest.approx(GAIT.least_width)


def test_feet_spread_no_farther_than_the_ankles_roll() -> None:
    robot = wbc.load("g1")
    reach = LegWorkspace(robot)
    roll = robot.q_max[robot.joint_index("left_ankle_roll_joint")]
    hip_height = 0.62  # m, of G1's hip pitch over its ankle
    # Off its hip by 0.7 of the extra distance, the leg leans; the ankle must undo it.
    assert math.atan2(0.7 * reach.max_spread, hip_height) < roll - 0.05
    assert GaitParameters.for_robot(robot).max_side_step == pytest.approx(reach.max_spread)
