"""The disturbance observer sees a force in the DCM; a trunk that yields gets its weight back."""

from __future__ import annotations

import math

import pytest

from wbc.walking.stabilizer.disturbance import DisturbanceObserver

DT, OMEGA, ZMP = 0.002, 3.5, 0.02 - 0.01j
SETTLING = 50  # ticks


def observe(force: complex, ticks: int) -> DisturbanceObserver:
    """Observe a pendulum whose DCM a force moves by `force` m/s, after it has settled."""
    observer, com, velocity = DisturbanceObserver(DT), 0.03 + 0.02j, 0j
    cosh, sinh = math.cosh(OMEGA * DT), math.sinh(OMEGA * DT)
    for _ in range(SETTLING):
        observer.update(velocity, OMEGA)
        observer.expect(0j)
    fixed_point = ZMP - force / OMEGA
    for _ in range(ticks):
        observer.update(velocity, OMEGA)
        observer.expect(OMEGA * (com + velocity / OMEGA - ZMP))
        way = com - fixed_point
        com = fixed_point + way * cosh + velocity / OMEGA * sinh
        velocity = way * OMEGA * sinh + velocity * cosh
    return observer


def test_a_pendulum_on_its_zmp_has_no_disturbance():
    assert abs(observe(0j, 50).rate) < 0.01


def test_the_rate_of_a_lasting_force_is_found_within_20_ms():
    assert observe(0.5 - 1.5j, 11).rate == pytest.approx(0.5 - 1.5j, rel=0.12)
    assert observe(0.5 - 1.5j, 50).rate == pytest.approx(0.5 - 1.5j, rel=0.03)


def test_an_estimate_that_settles_after_a_reset_is_no_disturbance():
    observer = DisturbanceObserver(DT)
    for tick in range(SETTLING):
        assert observer.update(0.05 * max(1.0 - abs(tick - 7) / 7, 0.0), OMEGA) == 0j
        observer.expect(0j)


def test_how_fast_the_robot_is_after_a_reset_is_no_disturbance():
    observer = observe(0.5 - 1.5j, 50)
    observer.reset()
    assert observer.update(0.7 + 0.3j, OMEGA) == 0j
