"""Preview control of the ZMP: the Riccati gains, and the closed form of the preview."""

from __future__ import annotations

import numpy as np
import pytest

from wbc.gait import ZmpSegment
from wbc.gait.planners.dcm import dcm_after, dcm_before
from wbc.gait.planners.preview_control import PreviewControlGains

OMEGA = 3.4
GAINS = PreviewControlGains(OMEGA)
STEPS = [
    ZmpSegment(0j, 0j, 1.6),
    ZmpSegment(0j, 0.2 + 0.1j, 0.2),
    ZmpSegment(0.2 + 0.1j, 0.2 + 0.1j, 0.6),
    ZmpSegment(0.2 + 0.1j, 0.3 + 0j, 0.5),
]


def ahead(time: float) -> list[ZmpSegment]:
    """What remains of the steps."""
    rest = []
    for start, end, duration in STEPS:
        if time < duration:
            done = max(time, 0.0) / duration
            rest.append(ZmpSegment(start + done * (end - start), end, duration - max(time, 0.0)))
        time -= duration
    return rest or [ZmpSegment(STEPS[-1].end, STEPS[-1].end, 1.0)]


def test_gains_solve_the_riccati_equation_and_stabilise():
    A, B = np.diag([1.0, 1.0], 1), np.array([[0.0], [0.0], [1.0]])
    poles = np.linalg.eigvals(A - B * np.array(GAINS.feedback))
    assert poles.real.max() < -0.5 * OMEGA
    np.testing.assert_allclose(np.sort(-poles.real), np.sort(GAINS.rates), rtol=1e-6)
    # Where the ZMP stays, so does the centre of mass.
    assert sum(GAINS.feedforward) == pytest.approx(GAINS.feedback[0], rel=1e-9)


def test_preview_is_the_integral_over_the_zmp_ahead():
    t = np.linspace(0.0, 12.0, 400_001)
    corners = np.concatenate(([0.0], np.cumsum([s.duration for s in STEPS])))
    points = np.array([STEPS[0].start, *(s.end for s in STEPS)])
    zmp = np.interp(t, corners, points.real) + 1j * np.interp(t, corners, points.imag)
    for rate, value in zip(GAINS.rates, GAINS.preview(STEPS), strict=True):
        assert value == pytest.approx(np.trapezoid(rate * np.exp(-rate * t) * zmp, t), abs=1e-6)


def test_zmp_under_preview_control_follows_without_a_jump_and_comes_to_rest():
    dt, com, velocity, acceleration = 0.002, 0j, 0j, 0j
    zmp, wanted, dcm = [], [], []
    for k in range(1900):
        segments = ahead(k * dt)
        jerk = GAINS.jerk(com, velocity, acceleration, GAINS.preview(segments))
        zmp.append(com - acceleration / OMEGA**2)
        dcm.append(com + velocity / OMEGA)
        wanted.append(segments[0].start)
        com += dt * velocity + dt**2 / 2 * acceleration + dt**3 / 6 * jerk
        velocity += dt * acceleration + dt**2 / 2 * jerk
        acceleration += dt * jerk
    error = np.abs(np.array(zmp) - np.array(wanted))
    assert error.max() < 0.02
    assert np.abs(np.diff(zmp)).max() < 2.0 * dt  # 2 m/s: the ideal ZMP moves at 1.1
    assert com == pytest.approx(STEPS[-1].end, abs=3e-3)
    assert np.abs(np.diff(dcm)).max() < 0.01


def test_dcm_after_a_time_undoes_dcm_before_it():
    segment = ZmpSegment(0.1j, 0.2 + 0.1j, 0.3)
    before = dcm_before(*segment, 0.25 + 0.05j, OMEGA)
    assert dcm_after(segment, before, 0.3, OMEGA) == pytest.approx(0.25 + 0.05j, abs=1e-12)
