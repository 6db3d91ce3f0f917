"""The disturbance observer sees a force in the DCM; a trunk that yields gets its weight back."""

from __future__ import annotations

import math

import pytest

from wbc.walking.stabilizer.disturbance import DisturbanceObserver

DT, OMEGA, ZMP = 0.002, 3.5, 0.02 - 0.01j
SETTLING = 50  # ticks


def observe(force: complex, ticks: int) -> DisturbanceObserver:
    """Observe the DCM of a pendulum that a force moves by `force` m/s, after it has settled."""
    observer, dcm = DisturbanceObserver(), 0.03 + 0.02j
    growth = math.exp(OMEGA * DT)
    for _ in range(SETTLING):
        observer.update(dcm, DT)
        observer.expect(0j)
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


def test_an_estimate_that_settles_after_a_reset_is_no_disturbance():
    observer = DisturbanceObserver()
    for tick in range(SETTLING):
        assert observer.update(0.015 * min(tick / 7, 1.0), DT) == 0j
        observer.expect(0j)


def test_where_the_dcm_is_after_a_reset_is_no_disturbance():
    observer = observe(0.5 - 1.5j, 50)
    observer.reset()
    assert observer.update(7.0 + 3.0j, DT) == 0j
