"""The DCM plan, the footsteps and the swing foot, against their own equations."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import wbc
from wbc.errors import GaitError
from wbc.gait import GaitParameters, Placement, SwingFoot, Velocity, ZmpSegment, solve_dcm
from wbc.gait.footsteps import clamp_footstep, lateral_sign, next_footstep, other_side
from wbc.geometry.planar import planar_rotation, wrap_angle
from wbc.walking.stabilizer import zmp_from_dcm_error

GAIT = GaitParameters(
    single_support=0.6,
    double_support=0.2,
    first_transfer=0.6,
    swing_height=0.06,
    touchdown_speed=0.05,
    step_width=0.17,
    least_width=0.14,
    max_step=0.45,
    max_side_step=0.2,
    max_turn=0.5,
    com_height=0.87,
)

coordinates = st.floats(-2.0, 2.0)
points = st.builds(complex, coordinates, coordinates)
durations = st.floats(0.05, 1.0)
segments = st.lists(st.builds(ZmpSegment, points, points, durations), min_size=1, max_size=6)
speeds = st.builds(Velocity, st.floats(-0.5, 0.5), st.floats(-0.12, 0.12), st.floats(-0.3, 0.3))
angles = st.floats(-3.1, 3.1)


@given(segments)
def test_dcm_started_on_the_plan_ends_on_the_last_zmp(plan: list[ZmpSegment]) -> None:
    omega, dt = 3.4, 2e-3
    dcm = solve_dcm(plan, omega).dcm
    for segment in plan:
        n = max(1, round(segment.duration / dt))
        h = segment.duration / n
        for k in range(n):
            # Midpoint rule of ξ̇ = ω (ξ − p) with the ZMP in the middle of the interval.
            p = segment.start + (segment.end - segment.start) * (k + 0.5) / n
            half = dcm + 0.5 * h * omega * (dcm - p)
            dcm += h * omega * (half - p)
    growth = math.exp(omega * sum(s.duration for s in plan))
    assert abs(dcm - plan[-1].end) < 1e-4 * growth


@given(segments)
def test_dcm_velocity_is_that_of_the_pendulum(plan: list[ZmpSegment]) -> None:
    omega, dt = 3.4, 1e-6
    now = solve_dcm(plan, omega)
    first = plan[0]
    share = dt / first.duration
    cut = ZmpSegment(
        first.start + (first.end - first.start) * share, first.end, first.duration - dt
    )
    later = solve_dcm([cut, *plan[1:]], omega)
    scale = 1.0 + abs(now.dcm) + abs(first.end - first.start) / first.duration
    assert abs((later.dcm - now.dcm) / dt - now.dcm_velocity) < 1e-3 * scale


def test_dcm_error_decays_with_the_gain() -> None:
    omega, gain, dt = 3.4, 4.0, 1e-4
    plan = [ZmpSegment(0j, 0j, 10.0)]
    dcm, time = 0.03 + 0.02j, 0.0
    while time < 0.5:
        dcm += dt * omega * (dcm - zmp_from_dcm_error(dcm, solve_dcm(plan, omega), omega, gain))
        time += dt
    assert abs(dcm) == pytest.approx(abs(0.03 + 0.02j) * math.exp(-gain * 0.5), rel=1e-3)


@given(speeds, points, angles, st.sampled_from(["left", "right"]))
def test_two_steps_move_the_com_at_the_commanded_velocity(
    velocity: Velocity, at: complex, yaw: float, side: str
) -> None:
    sign = lateral_sign(side)
    stance = Placement(at, yaw)
    swing = Placement(stance.to_world(complex(0.0, sign * GAIT.step_width)), yaw)
    first = next_footstep(stance, side, velocity, GAIT)
    second = next_footstep(first, other_side(side), velocity, GAIT)
    before = 0.5 * (stance.point + swing.point)
    after = 0.5 * (first.point + second.point)
    way = (after - before) * planar_rotation(-yaw)
    T = GAIT.step_duration
    assert wrap_angle(second.yaw - yaw) == pytest.approx(2.0 * velocity.turn * T, abs=1e-9)
    if velocity.turn == 0.0:
        # The middle between stance and swing advances 1.5 steps of forward motion.
        assert way.real == pytest.approx(1.5 * velocity.forward * T, abs=1e-9)
        assert way.imag * math.copysign(1.0, velocity.left) > -1e-9


@given(speeds, angles, st.sampled_from(["left", "right"]))
def test_feet_never_come_closer_than_is_safe(velocity: Velocity, yaw: float, side: str) -> None:
    stance = Placement(0.3 - 0.2j, yaw)
    for _ in range(6):
        wanted = next_footstep(stance, side, velocity, GAIT)
        landed = clamp_footstep(stance, side, wanted, GAIT)
        local = stance.to_local(landed.point)
        assert lateral_sign(side) * local.imag >= GAIT.least_width - 1e-9
        assert abs(local.real) <= GAIT.max_step + 1e-9
        stance, side = landed, other_side(side)


def test_velocity_is_clamped_to_what_the_steps_allow() -> None:
    limits = GAIT.max_velocity
    got = Velocity(9.0, 0.0, 0.0).clamped(GAIT)
    assert (got.forward, got.left, got.turn) == (limits.forward, 0.0, 0.0)
    got = Velocity(-0.9, -0.8, 0.7).clamped(GAIT)
    assert limits.usage(got.forward, got.left, got.turn) == pytest.approx(1.0)
    assert (got.left / got.forward, got.turn / got.forward) == pytest.approx((8 / 9, -7 / 9))
    assert Velocity(0.1, 0.0, 0.0).clamped(GAIT) == Velocity(0.1, 0.0, 0.0)


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_velocity_that_is_not_finite_is_refused(bad: float) -> None:
    with pytest.raises(GaitError, match="finite"):
        Velocity(bad, 0.0, 0.0).clamped(GAIT)


def test_invalid_gait_parameter_is_refused_by_name() -> None:
    with pytest.raises(GaitError, match=r"single_support = -1"):
        replace(GAIT, single_support=-1.0)
    with pytest.raises(GaitError, match="least_width"):
        replace(GAIT, least_width=0.5)


@pytest.mark.parametrize("name", ["talos", "g1", "romeo", "simple_humanoid"])
def test_default_gait_scales_to_every_robot(name: str) -> None:
    robot = wbc.load(name)
    gait = GaitParameters.for_robot(robot)
    assert 0.3 < gait.single_support < 0.8
    assert gait.max_step < robot.leg_length
    foot_width = robot.soles[0].half_width + robot.soles[1].half_width
    assert foot_width < gait.least_width <= gait.step_width


@given(points, points, angles, angles, st.floats(-0.03, 0.03))
def test_swing_foot_lands_on_its_target_with_the_touchdown_speed(
    start: complex, way: complex, yaw: float, end_yaw: float, step_up: float
) -> None:
    target = Placement(start + 0.2 * way, end_yaw, step_up)
    swing = SwingFoot(Placement(start, yaw), target, 0.6, 0.06, 0.05)
    dt, top, last = 0.002, -1.0, swing.motion.position.copy()
    while swing.time < 0.6 - 1e-9:
        swing.advance(dt, target)
        top = max(top, swing.motion.position[2])
        # No jump: neither in place nor against the stated velocity.
        moved = math.dist(swing.motion.position, last)
        assert moved < 0.03
        last = swing.motion.position.copy()
    assert complex(*swing.motion.position[:2]) == pytest.approx(target.point, abs=1e-6)
    assert swing.motion.position[2] == pytest.approx(step_up, abs=1e-4)
    assert swing.motion.velocity[2] == pytest.approx(-0.05, abs=1e-3)
    assert wrap_angle(swing.yaw - end_yaw) == pytest.approx(0.0, abs=1e-6)
    assert top == pytest.approx(max(0.0, step_up) + 0.06, abs=3e-3)


def test_time_to_a_landing_place_keeps_the_acceleration() -> None:
    start, goal, most = 0.1 - 0.2j, 0.5 - 0.1j, 60.0
    foot = SwingFoot(Placement(start, 0.0), Placement(goal, 0.0), 1.0, 0.05, 0.05)
    duration = foot.time_to(goal, most)
    s = 0.5 - math.sqrt(3.0) / 6.0  # where the quintic from 0 to 1 accelerates most
    peak = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) * abs(goal - start) / duration**2
    assert peak == pytest.approx(most)
    foot.motion.velocity[0] = 1.0
    assert foot.time_to(goal, most) < duration
    foot.motion.velocity[0] = -1.0
    assert foot.time_to(goal, most) > duration
    assert foot.time_to(start, most) == 0.0


def test_swing_foot_without_touchdown_keeps_descending() -> None:
    target = Placement(0.2 + 0j, 0.0)
    swing = SwingFoot(Placement(0j, 0.0), target, 0.5, 0.06, 0.05)
    for _ in range(350):
        swing.advance(0.002, target)
    assert swing.motion.position[2] < -0.03
    assert -0.45 < swing.motion.velocity[2] < -0.3


@given(points, st.floats(0.1, 0.6))
def test_moved_target_changes_the_swing_path_continuously(shift: complex, when: float) -> None:
    first, moved = Placement(0.3 + 0j, 0.0), Placement(0.3 + 0.02 * shift, 0.1)
    swing = SwingFoot(Placement(0j, 0.0), first, 0.6, 0.06, 0.05)
    last_v = swing.motion.velocity.copy()
    while swing.time < 0.6 - 1e-9:
        target = first if swing.time < 0.6 * when else moved
        swing.advance(0.002, target)
        # Velocity stays continuous: bounded acceleration through the change.
        assert math.dist(swing.motion.velocity, last_v) < 0.25
        last_v = swing.motion.velocity.copy()
    assert complex(*swing.motion.position[:2]) == pytest.approx(moved.point, abs=1e-6)


@given(st.floats(0.0, 0.5), st.floats(-1.0, 1.0), st.floats(-6.0, 6.0), st.floats(0.0, 0.4))
def test_a_foot_that_is_knocked_goes_on_from_where_it_is_and_lands_on_its_target(
    when: float, away: float, speed: float, height: float
) -> None:
    duration, dt = 0.5, 0.002
    target = Placement(0.3 + 0.1j, 0.2)
    swing = SwingFoot(Placement(0j, 0.0), target, duration, 0.06, 0.05)
    while swing.time < when * duration:
        swing.advance(dt, target)
    position, velocity = np.array([away, 0.1, height]), np.array([0.0, speed, 0.0])
    swing.follow(position, velocity, np.zeros(3))
    assert swing.knocked
    swing.duration = swing.time + 0.4
    swing.advance(dt, target)
    assert swing.motion.position == pytest.approx(position + dt * velocity, abs=0.005)
    while swing.time < swing.duration - 0.5 * dt:
        swing.advance(dt, target)
        if height > 0.03:  # it needs no apex
            assert swing.motion.position[2] <= height + 1e-9
    assert complex(*swing.motion.position[:2]) == pytest.approx(target.point, abs=1e-6)
    assert swing.motion.position[2] == pytest.approx(0.0, abs=1e-6)
    assert swing.motion.velocity[2] == pytest.approx(-0.05)


def test_swing_path_for_display_ends_at_the_target() -> None:
    target = Placement(0.3 + 0.1j, 0.2)
    swing = SwingFoot(Placement(0j, 0.0), target, 0.6, 0.06, 0.05)
    for _ in range(100):
        swing.advance(0.002, target)
    before = tuple(swing.motion.position)
    path = swing.path()
    assert path[0] == before == tuple(swing.motion.position)
    assert path[-1][:2] == pytest.approx((0.3, 0.1), abs=1e-6)


@pytest.mark.parametrize("ticks", [0, 10, 100, 250])
def test_swing_path_for_display_equals_the_later_motion(ticks: int) -> None:
    swing = SwingFoot(
        Placement(0j, 0.0, 0.0), Placement(0.3 + 0.1j, 0.2, 0.02), 0.6, 0.06, touchdown_speed=0.05
    )
    for _ in range(ticks):
        swing.advance(0.002, swing.target)
    path = swing.path(points=10)
    dt = (swing.duration - swing.time) / 5000
    for point in path[1:]:
        for _ in range(500):
            swing.advance(dt, swing.target)
        assert math.dist(point, swing.motion.position) < 3e-4
