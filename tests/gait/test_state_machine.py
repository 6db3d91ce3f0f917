"""State machine of the gait with the analytic DCM planner, on feet that follow their swing."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import wbc
from wbc.gait import (
    DcmPlanner,
    DcmReference,
    Feet,
    GaitCommand,
    GaitParameters,
    GaitState,
    GaitStateMachine,
    Phase,
    Placement,
    Velocity,
)
from wbc.gait.leg_workspace import LegWorkspace
from wbc.gait.planners.footstep_preview import zmp_over
from wbc.gait.speed_adaptation import SpeedAdaptation

ROBOT = wbc.load("talos")
WORKSPACE = LegWorkspace(ROBOT)
GAIT = GaitParameters.for_robot(ROBOT)
DT = 0.002
HALF = 0.5 * GAIT.step_width
SQUARE = Feet(Placement(complex(0.0, HALF), 0.0), Placement(complex(0.0, -HALF), 0.0))
WALK = Velocity(0.3, 0.0, 0.0)


class Ground:
    """Feet that follow the gait's swing exactly; contact when told."""

    def __init__(self, feet: Feet = SQUARE, adaptation: SpeedAdaptation | None = None) -> None:
        self.feet = feet
        self.planner = DcmPlanner()
        self.machine = GaitStateMachine(GAIT, feet, self.planner, adaptation=adaptation)
        self.command = GaitCommand()

    @property
    def state(self) -> GaitState:
        return self.machine.state

    def reference(self) -> DcmReference:
        return self.planner.reference(self.state)

    def run(self, duration: float, velocity: Velocity, contacts: frozenset[str] | None) -> None:
        state = self.state
        self.command.velocity = velocity
        for _ in range(round(duration / DT)):
            self.machine.update(DT, self.feet, self.command, contacts)
            self.machine.move_swing(DT, state.landing)
            if state.swing is not None:
                x, y, z = state.swing.motion.position
                placed = Placement(complex(x, y), state.swing.yaw, z)
                if state.swing_side == "left":
                    self.feet = Feet(placed, self.feet.right)
                else:
                    self.feet = Feet(self.feet.left, placed)


LEFT, BOTH = frozenset({"left"}), frozenset({"left", "right"})


def test_robot_stands_without_a_velocity_command() -> None:
    ground = Ground()
    ground.run(1.0, Velocity(), None)
    assert ground.state.phase is Phase.STAND
    assert ground.planner.footsteps(ground.state) == []
    assert ground.reference().zmp == pytest.approx(0j)
    assert ground.reference().dcm_velocity == 0j


def test_feet_alternate_and_end_side_by_side_after_a_stop() -> None:
    ground = Ground()
    ground.run(3.0, WALK, None)
    assert ground.state.steps >= 3
    ground.run(3.0, Velocity(), None)
    state, feet = ground.state, ground.feet
    assert state.phase is Phase.STAND
    apart = feet.left.to_local(feet.right.point)
    assert apart.real == pytest.approx(0.0, abs=1e-3)
    assert -apart.imag == pytest.approx(GAIT.step_width, abs=1e-3)


def test_swing_ends_early_when_the_foot_meets_the_ground() -> None:
    ground = Ground()
    ground.run(GAIT.first_transfer + 0.8 * GAIT.single_support, WALK, LEFT)
    assert ground.state.phase is Phase.SWING
    ground.run(DT, WALK, BOTH)
    assert ground.state.phase is Phase.TRANSFER
    # The plan keeps its time: what the swing saved is added to the transfer.
    saved = 0.2 * GAIT.single_support
    assert ground.state.duration == pytest.approx(GAIT.double_support + saved, abs=3 * DT)


def test_a_foothold_far_below_is_a_stair_to_a_robot_that_stands_or_came_over_stairs() -> None:
    low = SQUARE.right._replace(height=-0.08)
    standing = Ground(Feet(SQUARE.left, low))
    standing.run(DT, Velocity(), BOTH)
    assert standing.state.on_stairs
    walking = Ground()
    walking.run(GAIT.first_transfer + 0.5 * GAIT.single_support, WALK, LEFT)
    for before in (False, True):  # without footsteps given, it is a long step on a slope
        walking.state.landing = walking.state.landing._replace(height=-0.08)
        walking.state.on_stairs = before
        walking.machine.update(DT, walking.feet, walking.command, LEFT)
        assert walking.state.on_stairs is before


def test_contact_of_a_foot_right_after_lift_off_is_no_touchdown() -> None:
    ground = Ground()
    ground.run(GAIT.first_transfer + 0.1 * GAIT.single_support, WALK, LEFT)
    ground.run(0.1 * GAIT.single_support, WALK, BOTH)
    assert ground.state.phase is Phase.SWING


def test_swing_continues_until_touchdown() -> None:
    ground = Ground()
    unloaded = LEFT
    ground.run(GAIT.first_transfer + GAIT.single_support + 0.1, WALK, unloaded)
    assert ground.state.phase is Phase.SWING
    assert ground.feet.right.height < -0.01
    ground.run(DT, WALK, BOTH)
    assert ground.state.phase is Phase.TRANSFER


def test_plan_ends_at_rest_between_the_last_two_feet() -> None:
    ground = Ground()
    ground.run(1.0, WALK, None)
    places = [step.placement.point for step in ground.planner.footsteps(ground.state)]
    segments = zmp_over(ground.feet.of(ground.state.support).point, places, GAIT)
    assert segments[-1].end == pytest.approx(0.5 * (places[-2] + places[-1]))
    for one, following in itertools.pairwise(segments):
        assert one.end == pytest.approx(following.start)  # the ZMP never jumps


def test_planned_dcm_moves_with_its_own_velocity_from_phase_to_phase() -> None:
    ground = Ground()
    before, phases = ground.reference(), set()
    for tick in range(round(6.0 / DT)):
        ground.run(DT, WALK if 0.1 < tick * DT < 3.0 else Velocity(), None)
        now = ground.reference()
        # Beginning, going on and stopping change what is wanted: the plan may jump then.
        if 0.2 < tick * DT < 2.9:
            assert abs(now.dcm - before.dcm - DT * before.dcm_velocity) < 1e-3
            assert abs(now.zmp - before.zmp) < 0.01
        before = now
        phases.add(ground.state.phase)
    assert phases == set(Phase)
    assert before.dcm == pytest.approx(ground.feet.middle, abs=1e-6)


@given(
    st.floats(0.1, 2.5),
    st.builds(Velocity, st.floats(-0.3, 0.5), st.floats(-0.1, 0.1), st.floats(-0.3, 0.3)),
)
@settings(max_examples=25)
def test_new_velocity_changes_the_plan_within_the_step_and_continuously(
    when: float, wanted: Velocity
) -> None:
    ground = Ground()
    ground.run(when, WALK, None)
    state, planner = ground.state, ground.planner
    for tick in range(round(0.6 / DT)):
        before, steps, landing = (
            ground.reference(),
            state.steps,
            state.landing.point,
        )
        swings = state.phase is Phase.SWING
        ground.run(DT, wanted, None)
        if tick == 3 and wanted != WALK:
            assert planner.velocity != WALK
        if state.steps > steps:  # what is left of the change is for the next step
            break
        now = ground.reference()
        assert abs(now.dcm - before.dcm - DT * before.dcm_velocity) < 1e-3
        if swings:
            assert abs(state.landing.point - landing) < 1.5 * DT  # 1.5 m/s


def test_alternating_velocity_commands_change_the_plan_continuously() -> None:
    ground, rng, asked = Ground(), np.random.default_rng(0), []
    ground.run(1.0, WALK, None)
    for _ in range(round(2.0 / DT)):
        ground.run(DT, Velocity(*(WALK.forward + 0.1 * rng.normal(size=3)).tolist()), None)
        now = ground.reference()
        asked.append(now.dcm - now.dcm_velocity / GAIT.omega - now.zmp)  # beyond the plan's ZMP
    assert np.abs(asked).max() > 2e-3
    assert np.percentile(np.abs(np.diff(asked)), 99) < 6e-3


def test_stop_command_shortens_the_present_step_and_makes_the_next_the_last() -> None:
    stopped, went_on = Ground(), Ground()
    for ground, wanted in ((stopped, Velocity()), (went_on, WALK)):
        ground.run(GAIT.first_transfer + 0.1 * GAIT.single_support, WALK, None)
        ground.run(0.4 * GAIT.single_support, wanted, None)
    assert stopped.state.landing.point.real < went_on.state.landing.point.real - 0.02
    assert len(stopped.planner.footsteps(stopped.state)) > 1
    stopped.run(0.6 * GAIT.single_support, Velocity(), None)
    stopped.run(GAIT.step_duration + GAIT.first_transfer, Velocity(), None)
    assert stopped.state.steps == 2
    assert stopped.state.phase is Phase.STAND


def test_new_step_height_applies_to_a_foot_that_is_still_rising() -> None:
    ground = Ground()
    ground.run(GAIT.first_transfer + 0.2 * GAIT.single_support, WALK, None)
    higher = replace(GAIT, swing_height=2.0 * GAIT.swing_height)
    ground.machine.change_gait(higher, higher)
    ground.run(0.3 * GAIT.single_support, WALK, None)
    assert ground.feet.right.height == pytest.approx(2.0 * GAIT.swing_height, rel=0.02)


@pytest.mark.parametrize("speed", [0.5, 1.4])
def test_changed_gait_outlasts_the_next_steps_at_any_speed(speed: float) -> None:
    ground = Ground(adaptation=SpeedAdaptation(GAIT, WORKSPACE))
    fast = Velocity(speed * GAIT.max_step / GAIT.step_duration)
    ground.run(12.0, fast, None)
    usual = ground.state.gait.single_support
    higher = replace(GAIT, swing_height=1.5 * GAIT.swing_height)
    ground.machine.change_gait(higher, higher)
    assert ground.state.gait.single_support == usual
    for _ in range(3):
        ground.run(GAIT.step_duration, fast, None)
        assert ground.state.gait.swing_height == higher.swing_height
        assert ground.state.gait.single_support == usual


def test_gait_changed_during_a_quick_step_leaves_it_quick() -> None:
    quick = replace(GAIT, single_support=0.5 * GAIT.single_support)
    machine = GaitStateMachine(GAIT, SQUARE, DcmPlanner(), quick)
    machine.state.gait = quick
    higher, higher_quick = (replace(gait, swing_height=0.1) for gait in (GAIT, quick))
    machine.change_gait(higher, higher_quick)
    assert machine.state.gait is higher_quick
    assert machine.state.normal_gait is higher
    machine.change_gait(GAIT, GAIT)
    assert machine.state.recovery_gait is machine.state.normal_gait
