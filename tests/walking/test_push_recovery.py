"""Pushes that the soles cannot catch: quick steps, then the normal gait or standing again."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from cases import slow

import wbc
from wbc.gait import DcmReference, Phase, SwingFoot
from wbc.geometry.planar import yaw_of
from wbc.sim import Mujoco

pytest.importorskip("mujoco")

DIRECTIONS = {
    "forward": (1.0, 0.0, 0.0),
    "back": (-1.0, 0.0, 0.0),
    "left": (0.0, 1.0, 0.0),
    "right": (0.0, -1.0, 0.0),
}


@dataclass
class PushedRun:
    """A run with noisy sensors and the estimator, in which the torso is pushed once for 0.1 s.

    Attributes:
        report: of the run.
        walker: after the run.
        quick: (n, 2) time of each tick, s, and whether its step was a quick one.
        steps_before: touchdowns before the push.
    """

    report: wbc.Report
    walker: wbc.Walker
    quick: np.ndarray
    steps_before: int

    def quick_after(self, time: float) -> bool:
        """Whether any step after a time (s) was a quick one."""
        return bool(self.quick[self.quick[:, 0] >= time, 1].any())


def pushed_run(
    name: str,
    duration: float,
    *,
    direction: str = "left",
    size: float = 0.0,
    at: float = 0.3,
    velocity: tuple[float, float] = (0.0, np.inf),
    **options: object,
) -> PushedRun:
    """Run a robot that is pushed with `size` (N·s per kg) and walks forward until a time.

    Args:
        name: of the robot.
        duration: of the run, s.
        direction: of the push.
        size: of the push, N·s per kg of the robot.
        at: when it begins, s.
        velocity: forward velocity, m/s, and when it ends, s.
        options: of the walker.
    """
    robot = wbc.load(name)
    walker = wbc.Walker(robot, **options)
    quick, before = [], []

    def record(time: float) -> None:
        state = walker.gait_state
        quick.append((time, state.recovering or state.shortened))
        if time < at:
            before.append(walker.steps)
        walker.velocity = (velocity[0] if time < velocity[1] else 0.0, 0.0, 0.0)

    with Mujoco(robot, seed=3) as plant:
        plant.schedule_push(at, size * robot.mass * np.array(DIRECTIONS[direction]))
        report = wbc.run(walker, plant, duration, before_tick=record)
    return PushedRun(report, walker, np.array(quick), before[-1])


@pytest.mark.parametrize(
    ("name", "size", "direction"),
    [
        *(slow("g1", 0.4, direction) for direction in ("back", "left")),
        *(("g1", 0.4, direction) for direction in ("forward", "right")),
        *(("talos", 0.6, direction) for direction in ("back", "left")),
        *(slow("talos", 0.6, direction) for direction in ("forward", "right")),
    ],
)
def test_a_standing_robot_steps_when_pushed_and_stands_again_with_its_feet_side_by_side(
    name, size, direction
):
    run = pushed_run(name, 4.4, direction=direction, size=size)
    assert run.report.survived
    walker = run.walker
    # More would be feet that go back and forth: each comes back and drives the DCM out again.
    assert 0 < walker.steps <= 5
    assert walker.gait_state.phase is Phase.STAND
    assert not walker.gait_state.recovering
    between = walker.feet.left.to_local(walker.feet.right.point)
    assert abs(between - complex(0.0, -walker.gait.step_width)) < 0.03


@pytest.mark.parametrize("velocity", [(-1.0, 0.0, 0.0), slow((1.0, 0.0, 0.0))])
def test_a_standing_robot_survives_a_kick_that_no_sensor_tells(velocity):
    robot = wbc.load("g1")

    def kick(time: float) -> None:
        if abs(time - 0.3) < 1e-6:
            plant.kick(velocity)

    with Mujoco(robot, seed=3) as plant:
        report = wbc.run(wbc.Walker(robot), plant, 1.8, before_tick=kick)
    assert report.survived


def test_a_blow_on_an_arm_turns_the_torso_rather_than_pelvis_and_feet_and_it_turns_back():
    robot = wbc.load("g1")
    walker = wbc.Walker(robot)
    yaws = []

    def record(_: float) -> None:
        kin = wbc.Kinematics(robot, plant.ground_truth())
        yaws.append([yaw_of(kin.frame(name).rotation) for name in (robot.torso, robot.base)])

    with Mujoco(robot, seed=1) as plant:
        impulse = (0.6 * robot.mass, 0.0, 0.0)
        plant.schedule_push(0.3, impulse, duration=0.08, frame="left_elbow_joint")
        report = wbc.run(walker, plant, 3.0, before_tick=record)
    assert report.survived
    torso, base = np.degrees(yaws).T
    assert np.abs(torso - base).max() > 60.0
    assert np.abs(base).max() < np.abs(torso - base).max() / 3.0
    assert abs(torso[-1] - base[-1]) < 3.0


@pytest.mark.parametrize("name", ["g1", "talos", "simple_humanoid"])
def test_mirrored_pushes_make_a_standing_robot_step_with_mirrored_feet(name):
    walker = wbc.Walker(wbc.load(name))
    state, middle = walker.gait_state, walker.feet.middle
    planned = DcmReference(middle, 0j, middle)
    for shift in (0.1, 0.15, 0.2):
        first = []
        for sign in (1.0, -1.0):
            state.dcm = middle + complex(0.0, sign * shift)
            walker.stabilizer.push_recovery.update_standing(state, planned)
            first.append(state.requested_swing)
        assert sorted(first) == ["left", "right"]


@pytest.mark.parametrize(
    ("direction", "size"), [("left", 0.4), slow("right", 0.4), ("forward", 0.6)]
)
def test_a_walking_robot_is_quick_after_a_push_and_returns_to_its_normal_gait(direction, size):
    run = pushed_run("g1", 5.5, direction=direction, size=size, at=2.0, velocity=(0.2, np.inf))
    assert run.report.survived
    assert run.quick_after(2.0)
    usual = 3.5 / run.walker.gait.step_duration
    assert run.walker.steps - run.steps_before > usual
    assert not run.quick_after(4.5)


def test_a_robot_that_starts_to_walk_steps_with_the_other_foot_when_a_push_asks_for_it():
    run = pushed_run("g1", 1.8, direction="left", size=0.6, at=0.15, velocity=(0.05, 0.3))
    assert run.report.survived
    assert run.quick_after(0.15)


def test_the_same_push_fells_a_walker_without_a_recovery_gait():
    gait = wbc.Walker(wbc.load("g1")).gait
    run = pushed_run(
        "g1", 4.5, size=0.3, at=2.0, velocity=(0.2, np.inf), gait=gait, recovery_gait=gait
    )
    assert not run.report.survived
    assert not run.quick_after(0.0)


@pytest.mark.parametrize(("name", "speed"), [("g1", 0.39), slow("talos", 0.5)])
def test_an_undisturbed_walk_never_leaves_the_normal_gait(name, speed):
    run = pushed_run(name, 6.0, velocity=(speed, 4.0))
    assert run.report.survived
    assert not run.quick_after(0.0)


def test_recovery_steps_are_quicker_narrower_wider_and_longer_than_the_normal_ones():
    walker = wbc.Walker(wbc.load("g1"))
    normal, quick = walker.gait, walker.recovery_gait
    assert quick.step_duration < 0.5 * normal.step_duration
    assert quick.least_width < normal.least_width
    assert quick.max_side_step > normal.max_side_step
    assert quick.max_step > normal.max_step


def test_another_gait_changes_the_recovery_gait_with_it():
    walker = wbc.Walker(wbc.load("g1"))
    walker.change_gait(replace(walker.gait, swing_height=0.08))
    assert walker.recovery_gait.swing_height == 0.08
    assert walker.gait_state.recovery_gait is walker.recovery_gait


def test_another_gait_leaves_a_walker_without_quick_steps_without_them():
    robot = wbc.load("g1")
    gait = wbc.GaitParameters.for_robot(robot)
    walker = wbc.Walker(robot, gait=gait, recovery_gait=gait)
    walker.change_gait(replace(gait, swing_height=0.08))
    assert walker.recovery_gait is walker.gait


@pytest.mark.parametrize(("error", "returns_to_normal"), [(0.09, True), (0.25, False)])
def test_a_shortened_swing_has_the_time_that_its_foot_needs(error, returns_to_normal):
    walker = wbc.Walker(wbc.load("g1"))
    state, gait = walker.gait_state, walker.gait
    state.phase, state.time, state.duration = Phase.SWING, 0.15, gait.single_support
    start = state.other_foot._replace(point=state.other_foot.point - 0.15)
    state.landing = state.other_foot._replace(point=state.other_foot.point + 0.2)
    swing = state.swing = SwingFoot(
        start, state.landing, state.duration, gait.swing_height, gait.touchdown_speed
    )
    planned = DcmReference(state.stance.point, 0j, state.stance.point)
    state.dcm = planned.dcm + error
    walker.stabilizer.push_recovery.update_swing(state, planned, lambda _: planned, (0.0, 0.0))
    assert state.shortened
    assert state.recovering is not returns_to_normal
    assert state.duration < gait.single_support
    needed = swing.time_to(state.landing.point, 7.0 * gait.gravity)
    assert state.remaining >= needed > 0.1


def swinging_walker(time: float) -> wbc.Walker:
    """A walker whose right foot has been swinging for a time, s, without an error of the DCM."""
    walker = wbc.Walker(wbc.load("g1"))
    state, gait = walker.gait_state, walker.gait
    state.phase, state.time, state.duration = Phase.SWING, time, gait.single_support
    state.landing = state.other_foot
    state.swing = SwingFoot(
        state.other_foot,
        state.landing,
        state.duration,
        gait.swing_height,
        gait.touchdown_speed,
    )
    state.dcm = state.stance.point
    return walker


@pytest.mark.parametrize("rate", [1.5, -1.5, 1.0j])
def test_a_push_that_lasts_moves_the_landing_place_before_it_has_moved_the_dcm(rate):
    walker = swinging_walker(0.3)
    state = walker.gait_state
    planned = DcmReference(state.stance.point, 0j, state.stance.point)
    update = walker.stabilizer.push_recovery.update_swing
    assert update(state, planned, lambda _: planned, (0.0, 0.0))[1] == 0j
    state.disturbance = rate
    shift = update(state, planned, lambda _: planned, (0.0, 0.0))[1]
    # Of the rate, 0.5 m/s may be noise; the rest lasts for 0.05 s, and grows until touchdown.
    growth = np.exp(state.gait.omega * state.remaining)
    assert shift == pytest.approx(0.05 * (abs(rate) - 0.5) * rate / abs(rate) * growth)
    assert not state.shortened


def test_in_a_quick_step_the_landing_place_is_that_of_the_present_dcm():
    walker = swinging_walker(0.05)
    state = walker.gait_state
    planned = DcmReference(state.stance.point, 0j, state.stance.point)
    state.gait, state.dcm = state.recovery_gait, state.dcm + 0.2
    shifts = []
    for state.disturbance in (0j, 1.5 + 0j):
        update = walker.stabilizer.push_recovery.update_swing
        shifts.append(update(state, planned, lambda _: planned, (0.0, 0.0))[1])
    assert shifts[0] == shifts[1] != 0j


@pytest.mark.parametrize(("ahead", "crossing"), [(0.0, -1.0), (0.25, 0.0)])
def test_a_foot_crosses_over_behind_unless_the_dcm_is_planned_to_be_ahead(ahead, crossing):
    walker = swinging_walker(0.02)
    state = walker.gait_state
    state.gait, stance = state.recovery_gait, state.stance
    state.duration = state.gait.single_support
    behind = stance.to_world(stance.to_local(state.other_foot.point) - 0.25)
    state.feet = replace(state.feet, right=state.feet.right._replace(point=behind))
    growth = np.exp(state.gait.omega * state.remaining)
    at_touchdown = state.landing.point + ahead
    dcm = stance.point + (at_touchdown - stance.point) / growth
    planned = DcmReference(dcm, 0j, stance.point)
    state.dcm = dcm + 0.25j  # to the left, beyond the support foot
    walker.stabilizer.push_recovery.update_swing(state, planned, lambda _: planned, (0.0, 0.0))
    assert state.crossing == crossing


@pytest.mark.parametrize(("remaining", "goes_on"), [(0.06, True), (0.01, False)])
def test_a_foot_that_is_about_to_touch_the_ground_lands_when_a_push_comes(remaining, goes_on):
    walker = swinging_walker(0.0)
    state = walker.gait_state
    state.time = state.duration - remaining
    planned = DcmReference(state.stance.point, 0j, state.stance.point)
    state.dcm += 0.3  # ahead, where the foot could land farther
    update = walker.stabilizer.push_recovery.update_fixed_landing
    wanted = update(state, state.swing, lambda _: planned, (0.0, 0.0))
    assert state.is_quick
    assert (wanted is None) == goes_on
    assert (state.remaining >= 0.1) == goes_on


def test_a_late_foot_lands_where_the_ground_is_whatever_pushes():
    walker = swinging_walker(0.0)
    state = walker.gait_state
    state.time = state.duration + 0.01
    planned = DcmReference(state.stance.point, 0j, state.stance.point)
    state.dcm += 0.3
    update = walker.stabilizer.push_recovery.update_fixed_landing
    assert update(state, state.swing, lambda _: planned, (0.0, 0.0)) is planned
    assert not state.is_quick


@pytest.mark.parametrize(
    ("progress", "size", "direction", "swing_side"),
    [
        (0.85, 0.9, "left", "right"),
        slow(0.85, 0.9, "right", "left"),
        (0.75, 1.0, "left", "left"),
        slow(0.75, 1.0, "right", "right"),
    ],
)
def test_a_push_right_before_touchdown_is_survived(progress, size, direction, swing_side):
    robot = wbc.load("g1")
    walker = wbc.Walker(robot)
    pushed_at: list[float] = []

    def push(time: float) -> None:
        walker.velocity = (0.1, 0.0, 0.0)
        state = walker.gait_state
        swings = state.phase is Phase.SWING and state.swing_side == swing_side
        if swings and state.progress >= progress and walker.steps > 0 and not pushed_at:
            pushed_at.append(time)
            plant.push(size * robot.mass * np.array(DIRECTIONS[direction]), duration=0.08)

    with Mujoco(robot, seed=3) as plant:
        report = wbc.run(walker, plant, 3.8, before_tick=push)
    assert pushed_at
    assert report.survived
