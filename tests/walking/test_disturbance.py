"""The disturbance observer sees a force in the DCM; a trunk that yields gets its weight back."""

from __future__ import annotations

import math

import numpy as np
import pytest

import wbc
from wbc.gait import Phase
from wbc.walking.stabilizer.disturbance import DisturbanceObserver
from wbc.walking.stabilizer.swing_noise import SwingNoise

DT, OMEGA, ZMP = 0.002, 3.5, 0.02 - 0.01j


def observe(force: complex, ticks: int) -> DisturbanceObserver:
    """Observe the DCM of a pendulum that a force moves by `force` m/s."""
    observer, dcm = DisturbanceObserver(), 0.03 + 0.02j
    growth = math.exp(OMEGA * DT)
    for _ in range(ticks):
        observer.update(dcm, DT)
        observer.expect(OMEGA * (dcm - ZMP))
        fixed_point = ZMP - force / OMEGA
        dcm = fixed_point + (dcm - fixed_point) * growth
    return observer


def test_a_pendulum_on_its_zmp_has_no_disturbance():
    assert abs(observe(0j, 50).rate) < 0.01


def test_the_rate_of_a_lasting_force_is_found_within_20_ms():
    assert observe(0.5 - 1.5j, 11).rate == pytest.approx(0.5 - 1.5j, rel=0.12)
    assert observe(0.5 - 1.5j, 50).rate == pytest.approx(0.5 - 1.5j, rel=0.03)


def test_where_the_dcm_is_after_a_reset_is_no_disturbance():
    observer = observe(0.5 - 1.5j, 50)
    observer.reset()
    assert observer.update(7.0 + 3.0j, DT) == 0j


def test_a_disturbance_has_lasted_since_it_was_beyond_noise():
    observer, dcm = DisturbanceObserver(), 0j
    for tick in range(60):
        observer.update(dcm, DT, noise=0.5)
        observer.expect(0j)
        dcm += 1.0 * DT if 10 <= tick < 40 else 0j
    assert observer.lasted == 0.0
    observer = DisturbanceObserver()
    for tick in range(41):
        observer.update(1.0 * tick * DT, DT, noise=0.5)
        observer.expect(0j)
    # The low-pass filter of 10 ms is at half of the rate after 7 ms.
    assert observer.lasted == pytest.approx(40 * DT - 0.007, abs=2 * DT)


def swings(noise: SwingNoise, peaks: list[float], **state: object) -> float:
    """Let a robot swing a foot once for each peak of the disturbance; return the level after it."""
    gait = wbc.Walker(wbc.load("simple_humanoid")).gait_state
    for name, value in state.items():
        setattr(gait, name, value)
    for peak in peaks:
        gait.phase = Phase.SWING
        for gait.disturbance in (0.5j * peak, peak + 0j, 0.1 + 0j):
            noise.update(gait)
        gait.phase = Phase.TRANSFER
        noise.update(gait)
    return noise.level


def test_what_seems_to_be_a_push_in_most_swings_is_none():
    noise = SwingNoise()
    assert noise.level == pytest.approx(3.5)  # of a robot that is not known yet
    assert swings(noise, [0.3, 0.4, 0.3]) == pytest.approx(0.5)
    assert swings(noise, [4.0]) == pytest.approx(0.5)
    assert swings(noise, [1.5, 1.5]) == pytest.approx(2.5)
    noise.reset()
    assert noise.level == pytest.approx(3.5)


def test_swings_that_catch_a_push_teach_nothing_about_noise():
    noise = SwingNoise()
    assert swings(noise, 5 * [0.3]) == pytest.approx(0.5)
    assert swings(noise, 5 * [3.0], shortened=True) == pytest.approx(0.5)


def test_a_trunk_yields_to_a_step_that_catches_a_push_and_is_held_again_after_it():
    walker = wbc.Walker(wbc.load("g1"))
    usual = walker.gains.trunk_weight
    share = walker.gains.trunk_recovery_share
    trunk = walker._tasks._trunk
    tasks = trunk.tasks
    trunk.set_yielding(True)
    trunk.set_yielding(True)
    for task in tasks:
        np.testing.assert_allclose(task.weight, share * usual)
    tasks[0].weight = 7.0
    trunk.set_yielding(False)
    np.testing.assert_array_equal(tasks[0].weight, np.full(3, 7.0))
    np.testing.assert_allclose(tasks[1].weight, usual)
