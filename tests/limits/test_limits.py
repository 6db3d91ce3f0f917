"""Limits keep joints where they belong, in discrete time and with measurement noise."""

import copy
from types import SimpleNamespace

import numpy as np
import pytest
from coretools import ROBOTS, controller, many, robot, seeds, some
from hypothesis import given
from hypothesis import strategies as st

import wbc
from wbc.command import Status
from wbc.errors import LimitError
from wbc.limits import JointJerkLimit

BOT = "simple_humanoid"
MARGIN = 0.02


def bounds_at(limit, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A limit's bounds at joint positions q and velocities v."""
    state = wbc.State(np.concatenate((np.zeros(7), q)), np.concatenate((np.zeros(6), v)))
    return limit.bounds(SimpleNamespace(state=state))


def push_to_the_limit(
    limit, q: np.ndarray, v: np.ndarray, dt: float, steps: int, noise=None, push: float = 1e3
) -> tuple[np.ndarray, np.ndarray]:
    """Double integrators that always take the largest acceleration allowed; (steps, na) q, a."""
    qs, accelerations = [], []
    for _ in range(steps):
        nq, nv = (0.0, 0.0) if noise is None else noise()
        low, high = bounds_at(limit, q + nq, v + nv)
        a = np.clip(push, low, high)
        q, v = q + dt * v + 0.5 * dt * dt * a, v + dt * a
        qs.append(q)
        accelerations.append(a)
    return np.array(qs), np.array(accelerations)


@some
@given(
    seeds,
    st.sampled_from([0.0005, 0.002, 0.005, 0.01]),
    st.floats(2.0, 60.0),
)
def test_a_joint_never_passes_its_limit_nor_brakes_harder_whatever_it_is_told(seed, dt, braking):
    """From every admissible state, with random and extreme demands, for any period up to T."""
    bot, rng = robot(BOT), np.random.default_rng(seed)
    limit = wbc.JointPositionLimit(bot, margin=MARGIN, braking=braking, horizon=0.01)
    speed = wbc.JointVelocityLimit(bot, rng.uniform(0.3, 6.0), horizon=0.01, braking=braking)
    q = rng.uniform(limit.lower, limit.upper)
    v = rng.uniform(-1.0, 1.0, bot.na) * np.minimum(
        np.where(rng.random(bot.na) < 0.5, admissible_speed(limit, q), np.inf), speed.maximum
    )
    v = np.clip(v, -admissible_speed(limit, q, lower=True), admissible_speed(limit, q))
    demand = np.zeros(bot.na)
    for _ in range(round(0.4 / dt)):
        change = rng.random(bot.na) < 5.0 * dt
        demand[change] = rng.choice([-1e3, 1e3, 0.0, -5.0, 5.0], change.sum())
        low, high = bounds_at(limit, q, v)
        slow, fast = bounds_at(speed, q, v)
        assert (np.maximum(low, slow) <= np.minimum(high, fast) + 1e-9).all()
        assert (high >= -braking - 1e-9).all()
        assert (low <= braking + 1e-9).all()
        a = np.clip(demand, np.maximum(low, slow), np.minimum(high, fast))
        q, v = q + dt * v + 0.5 * dt * dt * a, v + dt * a
        assert np.maximum(q - limit.upper, limit.lower - q).max() <= 1e-9
        assert (np.abs(v) <= speed.maximum + 1e-9).all()


def admissible_speed(
    limit: wbc.JointPositionLimit, q: np.ndarray, *, lower: bool = False
) -> np.ndarray:
    """The docstring's φ of the distance to the upper or the lower limit."""
    d = q - limit.lower if lower else limit.upper - q
    knee = 2.0 * limit.horizon * limit.braking
    root = np.sqrt(np.maximum(2.0 * limit.braking * d - knee**2, 0.0))
    return np.where(d < 2.0 * limit.horizon * knee, d / (2.0 * limit.horizon), root)


def test_the_range_is_not_wasted():
    bot = robot(BOT)
    limit = wbc.JointPositionLimit(bot, braking=20.0)
    qs, _ = push_to_the_limit(limit, limit.upper - 0.5, np.zeros(bot.na), 0.002, 500)
    assert np.abs(qs[-1] - limit.upper).max() < 1e-6


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("dt", [0.001, 0.002, 0.004])
def test_with_measurement_noise_a_joint_stays_within_its_range(name, dt):
    bot = robot(name)
    rng = np.random.default_rng(1)
    limit = wbc.JointPositionLimit(bot)
    finite = np.isfinite(limit.upper)
    q = np.where(finite, limit.upper - 0.3, 0.0)

    def noise() -> tuple[np.ndarray, np.ndarray]:
        return 1e-3 * rng.standard_normal(bot.na), 0.05 * rng.standard_normal(bot.na)

    qs, a = push_to_the_limit(limit, q, np.zeros(bot.na), dt, round(3.0 / dt), noise)
    play = limit.upper - limit.lower
    wide = finite & (play > 0.5)
    assert (qs[:, wide] - bot.q_max[wide]).max() < 0.0
    settled = a[-round(0.5 / dt) :, wide]
    assert settled.std(axis=0).max() < 15.0


def test_the_bounds_change_with_noise_no_faster_than_the_docstring_says():
    bot = robot(BOT)
    limit = wbc.JointPositionLimit(bot, braking=20.0)
    T = limit.horizon
    rng = np.random.default_rng(0)
    for _ in range(300):
        q = limit.upper - rng.uniform(-0.05, 0.3, bot.na)
        v = rng.uniform(-3.0, 3.0, bot.na)
        high = bounds_at(limit, q, v)[1]
        assert (np.abs(bounds_at(limit, q, v + 1e-6)[1] - high) <= 1.001e-6 / T).all()
        slow = (v >= 0.0) & (v <= admissible_speed(limit, q))
        change = np.abs(bounds_at(limit, q + 1e-6, v)[1] - high)[slow & (q < limit.upper)]
        assert (change <= 0.501e-6 / T**2).all()


@many
@given(st.floats(-0.5, 2.0), st.floats(-20.0, 20.0))
def test_bounds_stay_within_the_braking_acceleration_and_do_not_cross(distance, speed):
    bot = robot(BOT)
    limit = wbc.JointPositionLimit(bot, braking=20.0)
    q = limit.upper - distance
    low, high = bounds_at(limit, q, np.full(bot.na, speed))
    assert (high >= -20.0).all()
    assert (low <= 20.0).all()
    viable = (speed >= 0.0) & (distance > 0.0) & (speed**2 <= 40.0 * max(distance, 0.0))
    if viable and distance < (limit.upper - limit.lower).min():
        assert (low <= high).all()


def test_a_joint_beyond_its_limit_returns_within_the_braking_acceleration():
    bot = robot(BOT)
    limit = wbc.JointPositionLimit(bot, braking=20.0)
    qs, a = push_to_the_limit(limit, limit.upper + 0.1, np.zeros(bot.na), 0.002, 1000)
    assert np.abs(a).max() <= 20.0
    assert np.abs(qs[-1] - limit.upper).max() < 2e-3
    assert (qs - limit.upper).min() > -1e-6


def test_a_joint_without_limits_has_infinite_bounds():
    bot = robot(BOT)
    limit = wbc.JointPositionLimit(bot)
    limit.lower, limit.upper = np.full(bot.na, -np.inf), np.full(bot.na, np.inf)
    low, high = bounds_at(limit, np.zeros(bot.na), np.ones(bot.na))
    assert (low == -np.inf).all()
    assert (high == np.inf).all()


@many
@given(st.sampled_from([0.001, 0.002, 0.01, 0.02]), st.floats(-3.0, 3.0))
def test_a_velocity_limit_is_approached_without_overshoot(dt, start):
    bot = robot(BOT)
    limit = wbc.JointVelocityLimit(bot, 2.0, braking=1e3)
    v = np.full(bot.na, start)
    for _ in range(round(0.5 / dt)):
        low, high = bounds_at(limit, np.zeros(bot.na), v)
        v = v + dt * np.clip(1e3, low, high)
        assert (v <= max(2.0, start) + 1e-9).all()
    np.testing.assert_allclose(v, 2.0, atol=1e-6)


def test_the_velocity_limit_stays_within_the_braking_acceleration():
    bot = robot(BOT)
    limit = wbc.JointVelocityLimit(bot, 2.0, braking=30.0)
    low, high = bounds_at(limit, np.zeros(bot.na), np.full(bot.na, 50.0))
    np.testing.assert_array_equal(high, -30.0)
    assert (low <= high).all()


@pytest.mark.parametrize("name", ROBOTS)
def test_a_controller_with_targets_beyond_the_limits_stops_before_them(name):
    """In free fall, integrating the command itself: every joint is driven outwards."""
    import pinocchio as pin

    bot = robot(name)
    rng = np.random.default_rng(2)
    limits = [wbc.JointPositionLimit(bot)]
    control = wbc.WholeBodyController(bot, limits=limits)
    far = np.where(rng.random(bot.na) < 0.5, -10.0, 10.0)
    control.add(wbc.PostureTask(bot, target=far))
    state = bot.standing()
    state.q[7:] = np.clip(state.q[7:], limits[0].lower, limits[0].upper)
    dt = control.dt
    for _ in range(400):
        command = control.step(state)
        assert command.status is Status.OK, command.explanation
        a = command.acceleration
        q = pin.integrate(bot.model, state.q, dt * state.v + 0.5 * dt * dt * a)
        state = wbc.State(q, state.v + dt * a)
        assert (state.q[7:] <= limits[0].upper + 1e-6).all()
        assert (state.q[7:] >= limits[0].lower - 1e-6).all()
    # Those whose range is not endless have arrived.
    end = np.where(far > 0.0, limits[0].upper, limits[0].lower)
    arrived = np.abs(state.q[7:] - end) < 0.01
    assert arrived[np.isfinite(end)].mean() > 0.6


@pytest.mark.parametrize("formulation", list(wbc.Formulation))
def test_of_limits_that_exclude_each_other_that_on_accelerations_holds_and_jerks_give_way(
    formulation,
):
    bot = robot(BOT)
    position = wbc.JointPositionLimit(bot, braking=20.0)
    state = bot.standing()
    state.q[7:] = position.upper
    state.v[6:] = 1.0  # asks for 20 rad/s² of braking

    def acceleration(*others):
        limits = [*others, position]
        return controller(bot, "none", limits=limits, formulation=formulation).step(state)

    jerk = JointJerkLimit(bot, 1e3)  # allows 2 rad/s² per tick
    command = acceleration(jerk)
    assert command.status is Status.OK
    np.testing.assert_allclose(command.acceleration[6:], -20.0)
    position.braking = np.full(bot.na, 5.0)
    hard = wbc.JointAccelerationLimit(bot, 5.0)
    np.testing.assert_allclose(acceleration(jerk, hard).acceleration[6:], -5.0)


def test_accelerations_change_by_no_more_than_the_jerk_limit_and_copies_go_on_alike():
    import pinocchio as pin

    bot = robot(BOT)
    control = wbc.WholeBodyController(bot, limits=[JointJerkLimit(bot, 2e3)])
    control.add(wbc.PostureTask(bot, target=bot.q_nominal[7:] + 0.2, kp=400.0))
    state, before, largest = bot.standing(), np.zeros(bot.nv), 0.0
    for _ in range(60):
        command = control.step(state)
        a = command.acceleration
        largest = max(largest, np.abs(a - before)[6:].max())
        before = a
        v = state.v + control.dt * a
        state = wbc.State(pin.integrate(bot.model, state.q, control.dt * v), v)
    assert largest == pytest.approx(4.0, abs=1e-6)
    other = copy.deepcopy(control)
    assert (other.step(state).tau == control.step(state).tau).all()


def test_braking_that_the_acceleration_limit_does_not_allow_is_refused():
    bot = robot(BOT)
    with pytest.raises(LimitError, match=r"counts on braking .* with 20 rad/s².*allows 5"):
        controller(
            bot,
            limits=[
                wbc.JointPositionLimit(bot, braking=20.0),
                wbc.JointAccelerationLimit(bot, 5.0),
            ],
        )


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda b: wbc.TorqueLimit(b, np.ones(3)), r"torque limit: maximum has shape \(3,\)"),
        (lambda b: wbc.TorqueLimit(b, scale=0.0), r"maximum of 'left_hip_yaw' is 0.*positive"),
        (lambda b: wbc.TorqueLimit(b, np.nan), r"maximum of 'left_hip_yaw' is nan"),
        (lambda b: wbc.JointVelocityLimit(b, -1.0), r"velocity limit: maximum of .* is -1"),
        (lambda b: wbc.JointVelocityLimit(b, horizon=0.0), r"horizon 0\.0 s must be positive"),
        (lambda b: wbc.JointVelocityLimit(b, braking=-2.0), r"braking of .* is -2"),
        (lambda b: wbc.JointAccelerationLimit(b, np.zeros(b.na)), r"acceleration limit: maximum"),
        (lambda b: wbc.JointPositionLimit(b, margin=-0.1), r"margin -0\.1 rad must not be negat"),
        (lambda b: wbc.JointPositionLimit(b, horizon=np.nan), r"horizon nan s must be positive"),
        (lambda b: wbc.JointPositionLimit(b, braking=0.0), r"braking of .* is 0"),
        (lambda b: wbc.JointPositionLimit(b, recovery=0.01), r"recovery 0\.01 s must not be below"),
        (lambda b: JointJerkLimit(b, dt=0.0), r"dt 0\.0 s must be positive"),
        (lambda b: JointJerkLimit(b, -1.0), r"jerk limit: maximum of .* is -1"),
    ],
)
def test_an_invalid_limit_is_refused(make, text):
    with pytest.raises(LimitError, match=text):
        make(robot(BOT))


def test_torque_bounds_hold_in_the_command_at_the_limit():
    bot = robot("talos")
    limit = wbc.TorqueLimit(bot, scale=0.6)
    control = controller(bot, "both", limits=[limit])
    control.tasks[0].acceleration[2] = 30.0
    command = control.step(bot.standing())
    assert command.status is Status.OK
    ratio = np.abs(command.tau) / limit.maximum
    assert ratio.max() == pytest.approx(1.0, abs=1e-9)
