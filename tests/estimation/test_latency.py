"""Latency compensation: the state that a command will find, from a reading that is old."""

import copy
from collections import deque

import numpy as np
import pinocchio as pin
import pytest
from coretools import few, random_state, robot, robots, seeds
from hypothesis import given
from hypothesis import strategies as st

import wbc
from wbc.errors import MeasurementError
from wbc.estimation import LatencyCompensation
from wbc.sim import Mujoco

DT = 0.002


def measurement(bot: wbc.Robot, state: wbc.State) -> wbc.Measurement:
    still = np.zeros(bot.na)
    return wbc.Measurement(
        0.0, still, still, np.zeros(3), np.zeros(3), ground_truth=state, joint_torque=still
    )


@few
@given(robots, st.integers(0, 10), seeds)
def test_prediction_is_where_the_planned_accelerations_lead(name, periods, seed):
    bot, rng = robot(name), np.random.default_rng(seed)
    state = random_state(bot, seed, speed=0.5)
    estimator = LatencyCompensation(wbc.GroundTruthEstimator(bot), bot, DT, latency=periods * DT)
    estimator.reset(state)
    shown = deque([state], maxlen=periods + 1)
    acceleration, fine = None, 20
    for _ in range(periods + 5):
        estimate = estimator.update(measurement(bot, shown[0]), acceleration=acceleration)
        if len(shown) == periods + 1:  # the first ones were at rest before their time
            np.testing.assert_allclose(estimate.state.v, shown[-1].v, atol=1e-9)
            error = pin.difference(bot.model, shown[-1].q, estimate.state.q)
            assert np.abs(error).max() < 2e-4  # the base turns meanwhile
        acceleration = 5.0 * rng.standard_normal(bot.nv)
        q, v = shown[-1].q, shown[-1].v
        for _ in range(fine):
            q = pin.integrate(bot.model, q, DT / fine * (v + 0.5 * DT / fine * acceleration))
            v = v + DT / fine * acceleration
        shown.append(wbc.State(q, v))


def test_without_latency_the_estimate_is_that_of_the_estimator():
    bot = robot("g1")
    plant = Mujoco(bot, dt=DT, seed=0)
    plain = wbc.Estimator(bot, DT)
    compensated = LatencyCompensation(wbc.Estimator(bot, DT), bot, DT, latency=0.0)
    for one in (plain, compensated):
        one.reset(bot.standing())
    planned = np.linspace(-1.0, 1.0, bot.nv)
    m = plant.measure()
    for _ in range(3):
        a = plain.update(m, acceleration=planned).state
        b = compensated.update(m, acceleration=planned).state
        assert (a.q == b.q).all()
        assert (a.v == b.v).all()


def test_a_measured_latency_is_followed_by_one_period_at_a_time():
    bot, seconds = robot("g1"), [0.0]
    estimator = LatencyCompensation(
        wbc.GroundTruthEstimator(bot), bot, DT, latency=lambda: seconds[0]
    )
    state = bot.standing()
    estimator.reset(state)
    found = []
    for seconds[0] in (0.006, 0.006, 0.006, 0.006, 0.0, 0.0):
        estimator.update(measurement(bot, state))
        found.append(round(estimator.latency / DT))
    assert found == [1, 2, 3, 3, 2, 1]
    again = copy.deepcopy(estimator)
    assert again.latency == estimator.latency


@pytest.mark.parametrize("latency", [-0.001, 0.051, float("nan")])
def test_a_latency_that_cannot_be_is_refused_by_its_value(latency):
    bot = robot("g1")
    with pytest.raises(MeasurementError, match=f"latency = {latency} s"):
        LatencyCompensation(wbc.GroundTruthEstimator(bot), bot, DT, latency=latency)


def test_g1_walks_with_30_ms_of_latency():
    """Without compensation it falls within 3.5 s."""
    bot = robot("g1")
    plant = Mujoco(bot, dt=DT, latency=0.016, sensor_latency=0.014, seed=0)
    walker = wbc.Walker(bot, DT)
    estimator = LatencyCompensation(wbc.Estimator(bot, DT), bot, DT, latency=0.03)

    def command(time: float) -> None:
        walker.velocity = (0.3 if time > 0.5 else 0.0, 0.0, 0.0)

    report = wbc.run(walker, plant, 4.0, estimator=estimator, before_tick=command)
    assert report.survived
    assert report.dcm_error_rms_mm < 15.0
