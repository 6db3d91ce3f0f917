"""Steps at each walking speed."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

import wbc
from wbc.gait import Velocity
from wbc.gait.leg_workspace import LegWorkspace
from wbc.gait.speed_adaptation import SpeedAdaptation
from wbc.sim import Mujoco

ROBOT = wbc.load("simple_humanoid")
WORKSPACE = LegWorkspace(ROBOT)
GAIT = wbc.GaitParameters.for_robot(ROBOT)
USUAL = GAIT.max_step / GAIT.step_duration
DT = 0.002


def test_durations_stay_up_to_the_usual_speed_and_shrink_continuously_beyond() -> None:
    adaptation = SpeedAdaptation(GAIT, WORKSPACE)
    for speed in (0.0, 0.3 * USUAL, USUAL):
        gait = adaptation.at(Velocity(speed))
        assert gait.single_support == pytest.approx(GAIT.single_support)
        assert gait.double_support == pytest.approx(GAIT.double_support)
    before = GAIT
    for k in range(41, 60):
        gait = adaptation.at(Velocity(k / 40 * USUAL))
        assert 0.0 < before.step_duration - gait.step_duration < 0.03
        assert 0.0 < before.double_support - gait.double_support < 0.03
        assert k / 40 * USUAL * gait.step_duration < gait.max_step
        before = gait


def test_the_rear_foot_is_left_less_far_behind_the_less_double_support_there_is() -> None:
    adaptation = SpeedAdaptation(GAIT, WORKSPACE)
    assert adaptation.at(Velocity(0.5 * USUAL)).trail == GAIT.trail
    speed = 1.8 * USUAL
    fast = adaptation.at(Velocity(speed))
    assert 0.5 < fast.trail < GAIT.trail
    step = speed * fast.step_duration
    assert WORKSPACE.com_height(step) < fast.com_height < GAIT.com_height


@given(st.floats(-GAIT.max_velocity.backward, GAIT.max_velocity.forward), st.floats(-0.1, 0.1))
def test_velocity_ramps_beyond_the_usual_speed_and_stays_within_the_limits(
    forward: float, left: float
) -> None:
    adaptation = SpeedAdaptation(GAIT, WORKSPACE)
    fast, wanted = Velocity(GAIT.max_velocity.forward), Velocity(forward, left).clamped(GAIT)
    for target in (fast, wanted):
        for _ in range(5000):
            before = adaptation.velocity
            now = adaptation.ramp(target, DT, walking=True)
            assert GAIT.max_velocity.usage(now.forward, now.left, now.turn) <= 1.0 + 1e-9
            if max(before.forward, now.forward) > USUAL:
                assert min(before.forward, USUAL) <= now.forward + 1e-3
                assert now.forward - max(before.forward, USUAL) < 1e-3
            if now is target:
                break
        assert now is target
    assert adaptation.ramp(fast, DT, walking=False).forward < USUAL + 1e-3


def test_steps_longer_than_commanded_slow_the_next_ones_until_the_mean_is_right() -> None:
    adaptation = SpeedAdaptation(GAIT, WORKSPACE)
    wanted = Velocity(1.5 * USUAL)
    for _ in range(5000):
        adaptation.ramp(wanted, DT, walking=True)
    longer, duration = 1.05, 0.5
    for _ in range(30):
        for _ in range(250):
            adaptation.ramp(wanted, DT, walking=True)
        made = longer * adaptation.velocity.forward
        adaptation.observe_step(made * duration, duration)
    assert made == pytest.approx(wanted.forward, rel=1e-3)
    # The correction is of fast walking, and bounded.
    for _ in range(30):
        adaptation.observe_step(0.0, duration)
    for _ in range(1000):
        adaptation.ramp(wanted, DT, walking=True)
    assert adaptation.velocity.forward == pytest.approx(
        min(1.1 * wanted.forward, GAIT.max_velocity.forward)
    )
    slow = Velocity(0.5 * USUAL)
    for _ in range(5000):
        adaptation.ramp(slow, DT, walking=True)
    assert adaptation.velocity is slow


def test_the_first_step_out_of_standing_is_not_faster_than_the_usual_ones() -> None:
    adaptation = SpeedAdaptation(GAIT, WORKSPACE)
    for _ in range(1000):
        adaptation.ramp(Velocity(1.5 * USUAL), DT, walking=False)
    assert adaptation.velocity.forward < USUAL + 1e-3


def test_robot_walks_faster_than_at_its_usual_cadence() -> None:
    robot = wbc.load("g1")  # whose narrow feet hold less than a fast leg turns: its arms swing
    walker = wbc.Walker(robot)
    gait = walker.gait
    usual = gait.max_step / gait.step_duration
    shoulder = robot.joint_names.index("left_shoulder_pitch_joint")
    swing: list[float] = []
    marks: list[tuple[float, float]] = []
    with Mujoco(robot, seed=0) as plant:
        walker.velocity = (1.7 * usual, 0.0, 0.0)

        def mark(time: float) -> None:
            if walker.steps in (8, 10, 12, 14) and len(marks) < walker.steps // 2 - 3:
                marks.append((time, float(plant.ground_truth().q[0])))
            if walker.steps >= 8:
                swing.append(float(plant.ground_truth().q[7 + shoulder]))

        report = wbc.run(walker, plant, 8.0, before_tick=mark)
    assert report.survived, report.table()
    (t0, x0), (t1, x1) = marks[0], marks[-1]
    assert (x1 - x0) / (t1 - t0) == pytest.approx(1.7 * usual, rel=0.05)
    assert t1 - t0 < 0.8 * 6 * gait.step_duration
    assert max(swing) - min(swing) > 0.2  # rad
