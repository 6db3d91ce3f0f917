"""Regions that frames and the centre of mass stay in, or out of, at both levels."""

import numpy as np
import pinocchio as pin
import pytest
from coretools import along_velocity, few, hand, random_state, robot, robots, seeds
from hypothesis import given
from hypothesis import strategies as st

import wbc
from wbc.command import Status
from wbc.errors import LimitError
from wbc.limits import BarrierLimit, BarrierRows, ComPolygonLimit, FrameBoxLimit, KeepOutLimit

KINDS = ("box", "sphere", "rounded box", "inside", "polygon")


def make(kind: str, bot: wbc.Robot, state: wbc.State, seed: int) -> BarrierLimit:
    rng = np.random.default_rng(seed)
    kin, frame = wbc.Kinematics(bot, state), hand(bot)
    p = kin.frame(frame).translation
    turn = pin.exp3(rng.standard_normal(3))
    if kind == "box":
        return FrameBoxLimit(frame, p - rng.uniform(0.1, 1.0, 3), p + rng.uniform(0.1, 1.0, 3))
    if kind == "sphere":
        return KeepOutLimit(frame, pin.SE3(turn, p + 0.3 * rng.standard_normal(3)), radius=0.1)
    if kind == "polygon":
        return ComPolygonLimit(kin.p_com[:2] + 0.1 * rng.standard_normal((8, 2)))
    size = rng.uniform(0.05, 0.2, 3)
    near = 0.3 * size if kind == "inside" else size + 0.2
    center = p - turn @ (near * rng.choice([-1.0, 1.0], 3))
    return KeepOutLimit(frame, pin.SE3(turn, center), half_size=size, radius=0.03)


def rows_at(limit: BarrierLimit, bot: wbc.Robot, state: wbc.State) -> BarrierRows:
    m = limit.size
    rows = BarrierRows(np.full(m, np.inf), np.zeros((m, bot.nv)), np.zeros(m))
    limit.write_barrier(wbc.Kinematics(bot, state), rows)
    return rows


@few
@given(robots, st.sampled_from(KINDS), seeds)
def test_jacobian_and_bias_are_the_derivatives_of_the_barrier(name, kind, seed):
    bot = robot(name)
    state = random_state(bot, seed, speed=0.3)
    limit = make(kind, bot, state, seed)
    limit.bind(bot)
    h = 1e-5
    before, now, after = along_velocity(bot, state, h, lambda at: rows_at(limit, bot, at))
    used = np.isfinite(now.h)
    assert used.any()
    rate = (after.h[used] - before.h[used]) / (2.0 * h)
    np.testing.assert_allclose((now.J @ state.v)[used], rate, rtol=1e-4, atol=1e-4)
    second = ((after.J - before.J) @ state.v)[used] / (2.0 * h)
    np.testing.assert_allclose(now.bias[used], second, rtol=1e-4, atol=1e-4)


def sphere_in_the_way(start: np.ndarray, target: np.ndarray) -> pin.SE3:
    return pin.SE3(np.eye(3), 0.5 * (start + target) + np.array([0.0, 0.01, 0.0]))


def test_a_hand_goes_round_a_keep_out_region_and_stops_at_the_wall_of_a_box():
    panda = wbc.load_fixed_base("panda")
    ik = wbc.InverseKinematics(panda)
    task = ik.add(wbc.PositionTask("panda_hand"))
    ik.step(panda.q_nominal, 0.01)
    start = task.target.copy()
    task.target = start + np.array([0.0, 0.3, 0.0])
    region = KeepOutLimit("panda_hand", sphere_in_the_way(start, task.target), radius=0.05)
    box = FrameBoxLimit("panda_hand", (-1.0, -1.0, 0.0), (1.0, start[1] + 0.25, 1.5))
    ik.set_limits([*ik.limits, region, box])
    q, nearest = panda.q_nominal.copy(), np.inf
    for _ in range(600):
        q = pin.integrate(panda.model, q, 0.01 * ik.step(q, 0.01))
        p = ik.kinematics.frame("panda_hand").translation
        nearest = min(nearest, np.linalg.norm(p - region.placement.translation))
    assert 0.049 < nearest < 0.06
    assert p[1] == pytest.approx(start[1] + 0.25, abs=1e-3)
    found = ik.reach(q, restarts=1)
    assert not found.reached
    assert "panda_hand box [y maximum]" in found.explanation


def test_the_controller_holds_them_too_and_an_inadmissible_start_comes_back():
    bot = robot("simple_humanoid")
    frame = "left_hand"
    control = wbc.WholeBodyController(bot, limits=[wbc.TorqueLimit(bot)])
    control.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in bot.soles])
    com = control.add(wbc.ComTask())
    control.add(wbc.PostureTask(bot, weight=0.1))
    p = wbc.Kinematics(bot, bot.standing()).frame(frame).translation
    box = FrameBoxLimit(frame, p - 1.0, p + np.array([0.1, 1.0, -0.02]))  # too high by 2 cm
    feet = [wbc.Kinematics(bot, bot.standing()).frame(s.name).translation for s in bot.soles]
    corners = [
        f + np.array([x, y, 0.0]) for f in feet for x in (-0.02, 0.03) for y in (-0.02, 0.02)
    ]
    polygon = ComPolygonLimit(np.array(corners))
    control.set_limits([*control.limits, box, polygon])
    control.add(wbc.PositionTask(frame, p + np.array([0.4, 0.0, 0.1]), weight=30.0))
    state = bot.standing()
    com.target = wbc.Kinematics(bot, state).p_com + np.array([0.2, 0.0, 0.0])
    for _ in range(600):
        command = control.step(state)
        assert command.status is Status.OK
        v = state.v + control.dt * command.acceleration
        state = wbc.State(pin.integrate(bot.model, state.q, control.dt * v), v)
        h = rows_at(polygon, bot, state).h
        assert h[np.isfinite(h)].min() > -1e-3
    kin = wbc.Kinematics(bot, state)
    over = kin.frame(frame).translation - box.upper
    assert over[0] == pytest.approx(0.0, abs=2e-3)
    assert over[2] < 1e-3
    assert kin.p_com[0] == pytest.approx(polygon.polygon[:, 0].max(), abs=2e-3)


def test_of_a_priority_the_polygon_is_a_task_that_gives_way():
    bot = robot("simple_humanoid")
    ik = wbc.InverseKinematics(bot)
    for sole in bot.soles:
        ik.add(wbc.FrameTask(sole.name, priority=0))
    com = ik.add(wbc.ComTask())
    ik.step(bot.q_nominal, 0.01)
    com.target = com.target + np.array([0.1, 0.0, 0.0])
    center = com.target[:2] - (0.1, 0.0)
    square = center + 0.02 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    polygon = ComPolygonLimit(square, priority=2)
    ik.set_limits([*ik.limits, polygon])
    q = bot.q_nominal.copy()
    for _ in range(200):
        q = pin.integrate(bot.model, q, 0.02 * ik.step(q, 0.02))
    assert np.abs(ik.kinematics.p_com - com.target).max() < 5e-3
    polygon.priority, com.priority = 1, 2
    for _ in range(200):
        q = pin.integrate(bot.model, q, 0.02 * ik.step(q, 0.02))
    assert ik.kinematics.p_com[0] - center[0] == pytest.approx(0.02, abs=2e-3)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: FrameBoxLimit("torso", np.zeros(2), np.ones(3)), r"lower has shape \(2,\)"),
        (lambda: FrameBoxLimit("torso", np.ones(3), np.ones(3)), "must be below upper"),
        (lambda: KeepOutLimit("torso", pin.SE3.Identity()), "nor all of them zero"),
        (lambda: KeepOutLimit("torso", pin.SE3.Identity(), radius=-1.0), "must not be negative"),
        (lambda: KeepOutLimit("torso", np.eye(4), radius=0.1), "placement is a ndarray"),
        (lambda: ComPolygonLimit(np.zeros((4, 2))), "corners; it must have 3 to 16"),
        (lambda: ComPolygonLimit(np.zeros(4)), r"points of shape \(4,\)"),
    ],
)
def test_an_invalid_limit_is_refused(make, text):
    with pytest.raises(LimitError, match=text):
        make()
