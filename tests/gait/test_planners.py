"""Planners: the preview of footsteps, the library's by name, and one's own behind the protocol."""

from __future__ import annotations

import copy
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import wbc
from wbc.errors import PlannerNotFound
from wbc.gait import (
    DcmPlanner,
    DcmReference,
    GaitCommand,
    GaitParameters,
    GaitState,
    Placement,
    PlannedFootstep,
    StepPlan,
    Velocity,
    make_planner,
    solve_dcm,
)
from wbc.gait.planners import PLANNER_NAMES
from wbc.gait.planners.footstep_preview import FootstepPreview, zmp_over
from wbc.sim import Mujoco

GAIT = GaitParameters.for_robot(wbc.load("talos"))
HALF = 0.5 * GAIT.step_width
errors = st.floats(-0.15, 0.15)
velocities = st.builds(
    Velocity,
    st.sampled_from([0.0, -0.2, 0.4]),
    st.sampled_from([0.0, 0.1]),
    st.sampled_from([0.0, -0.3]),
)
feet = st.builds(Placement, st.builds(complex, errors, errors), st.floats(-3.0, 3.0))


@given(st.lists(st.tuples(feet, velocities, st.sampled_from(["left", "right"])), max_size=4))
def test_arrival_dcm_from_foot_axes_equals_that_from_world_footsteps(
    asked: list[tuple[Placement, Velocity, str]],
) -> None:
    preview = FootstepPreview(GAIT, [])
    for foot, velocity, side in asked:
        steps = preview.steps(foot, side, velocity, 3)
        assert len(steps) == (1 if velocity.is_zero else 3)
        segments = zmp_over(foot.point, [step.placement.point for step in steps], GAIT)
        expected = solve_dcm(segments, GAIT.omega).dcm
        assert preview.arrival_dcm(foot, side, velocity, 3) == pytest.approx(expected, abs=1e-12)


def test_given_footsteps_stay_fixed_in_the_world_when_the_measured_foot_moves() -> None:
    given_steps = [
        PlannedFootstep("right", Placement(0.2 - HALF * 1j, 0.0)),
        PlannedFootstep("left", Placement(0.2 + HALF * 1j, 0.0)),
    ]
    preview = FootstepPreview(GAIT, given_steps)
    for x in (0.0, 0.01):
        steps = preview.steps(Placement(complex(x, HALF), 0.0), "left", Velocity(), 3)
        places = [step.placement.point for step in steps]
        assert places == pytest.approx([p.point for _, p in given_steps])


class ConstantZmp:
    """A planner outside the library: stands, with the ZMP at a fixed offset from the middle."""

    def __init__(self, offset: complex) -> None:
        self.offset = offset

    def reset(self, state: GaitState) -> None:
        self.zmp = state.feet.middle + self.offset

    def next_swing(self, state: GaitState, command: GaitCommand) -> str | None:
        return None

    def update(self, state: GaitState, command: GaitCommand, dt: float) -> StepPlan:
        return StepPlan()

    def reference(self, state: GaitState, landing: Placement | None = None) -> DcmReference:
        return DcmReference(self.zmp, 0j, self.zmp)

    def footsteps(self, state: GaitState) -> list[PlannedFootstep]:
        return []


def test_walker_follows_a_user_defined_planner() -> None:
    robot = wbc.load("simple_humanoid")
    walker = wbc.Walker(robot, planner=ConstantZmp(0.02 - 0.03j))
    walker.velocity = (0.3, 0.0, 0.0)  # which this planner ignores
    with Mujoco(robot, seed=0) as plant:
        report = wbc.run(walker, plant, 2.5)
        truth = wbc.Kinematics(robot, plant.ground_truth())
    assert report.survived
    assert report.steps == 0
    soles = [truth.frame(sole.name).translation for sole in robot.soles]
    offset = truth.p_com - 0.5 * (soles[0] + soles[1])
    assert offset[:2] == pytest.approx([0.02, -0.03], abs=0.006)


class ShortSteps:
    """Steps on the spot, with swings of its own duration, resting the ZMP on the support foot."""

    duration = 0.35

    def reset(self, state: GaitState) -> None:
        self.begun = None

    def next_swing(self, state: GaitState, command: GaitCommand) -> str | None:
        return "left" if state.swing is None else state.support

    def update(self, state: GaitState, command: GaitCommand, dt: float) -> StepPlan:
        if state.swing is None and state.time == 0.0:
            self.start = state.feet.of(state.swing_side)
        swings = state.phase is wbc.gait.Phase.SWING
        return StepPlan(self.start, self.duration) if swings else StepPlan()

    def reference(self, state: GaitState, landing: Placement | None = None) -> DcmReference:
        zmp = state.feet.of(state.support).point
        return DcmReference(zmp, 0j, zmp)

    def footsteps(self, state: GaitState) -> list[PlannedFootstep]:
        return []


def test_planner_sets_the_duration_of_a_swing() -> None:
    robot = wbc.load("simple_humanoid")
    walker = wbc.Walker(robot, planner=ShortSteps())
    state, lasted = robot.standing(), 0.0
    while lasted == 0.0 or walker.gait_state.phase is wbc.gait.Phase.SWING:
        walker.step(wbc.Estimate(state))  # kinematic: the state never moves
        if walker.gait_state.phase is wbc.gait.Phase.SWING:
            lasted = walker.gait_state.time
    assert walker.steps == 1
    assert lasted == pytest.approx(ShortSteps.duration, abs=2.0 * walker.dt)


OTHERS = [name for name in PLANNER_NAMES if name != "dcm"]


@pytest.mark.parametrize("name", OTHERS)
def test_planner_walks_turns_and_stops_near_the_analytic_plan(name):
    robot = wbc.load("simple_humanoid")
    walker = wbc.Walker(robot, planner=name)
    errors = []

    def before_tick(time: float) -> None:
        walker.velocity = (0.3, 0.0, 0.15) if 0.3 < time < 3.0 else (0.0, 0.0, 0.0)
        state = walker.gait_state
        analytic = DcmPlanner.reference(walker.planner, state)
        if time > 1.5:
            errors.append(abs(state.dcm - state.dcm_offset - analytic.dcm))

    with Mujoco(robot, seed=1) as plant, warnings.catch_warnings():
        warnings.simplefilter("error")
        report = wbc.run(walker, plant, 5.5, before_tick=before_tick)
    assert report.survived
    assert report.steps >= 4
    assert walker.gait_state.phase is wbc.gait.Phase.STAND
    assert np.sqrt(np.mean(np.square(errors))) < 0.01


@pytest.mark.filterwarnings("ignore::wbc.gait.PlanFailed")  # the push is beyond its plans
@pytest.mark.parametrize("name", OTHERS)
def test_planner_survives_a_push_by_quick_steps_and_a_copy_does_the_same(name):
    robot = wbc.load("g1")
    walker, plant, estimator = wbc.Walker(robot, planner=name), Mujoco(robot), wbc.Estimator(robot)
    estimator.reset(plant.ground_truth())
    walker.reset(plant.ground_truth())
    walker.velocity = (0.2, 0.0, 0.0)
    plant.schedule_push(1.6, [0.0, 0.45 * robot.mass, 0.0])
    loop = (walker, plant, estimator)

    def run(walker, plant, estimator, ticks):
        quick = False
        for _ in range(ticks):
            command = walker.step(estimator.update(plant.measure()))
            plant.step(command)
            quick |= walker.gait_state.shortened
        return quick, command.tau

    run(*loop, 820)
    other = copy.deepcopy(loop)
    quick, tau = run(*loop, 900)
    assert quick
    np.testing.assert_array_equal(run(*other, 900)[1], tau)
    height = plant.ground_truth().q[2]
    assert height > 0.8 * robot.standing().q[2]


def test_planner_is_made_by_name_or_refused_by_name():
    robot = wbc.load("simple_humanoid")
    assert type(make_planner("dcm", robot)) is DcmPlanner
    assert type(wbc.Walker(robot).planner) is DcmPlanner
    with pytest.raises(PlannerNotFound, match=r"'preveiw'; did you mean 'preview'\?"):
        wbc.Walker(robot, planner="preveiw")
    with pytest.raises(PlannerNotFound, match="neither a name nor an object"):
        wbc.Walker(robot, planner=DcmPlanner)
