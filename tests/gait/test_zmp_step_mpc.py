"""The model-predictive planner's quadratic program against another solver and its own equations."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from wbc.gait.planners.zmp_step_mpc import NODES, ZmpStepMpc

STEPS = 3
SHARES = np.array([0.4, 0.05, 0.005])
HALF = (0.10, 0.05)
ZMP_BOUNDS = np.stack((-np.tile(HALF, NODES), np.tile(HALF, NODES)))
STEP_BOUNDS = np.array([[-0.3, -0.05] * STEPS, [0.3, 0.2] * STEPS])
STRAIGHT = np.ones(NODES, dtype=complex), np.ones(STEPS, dtype=complex)
errors = st.builds(complex, st.floats(-0.1, 0.1), st.floats(-0.06, 0.06))


def solve(program: ZmpStepMpc, error: complex, turn: complex = 1.0 + 0j):
    node_axes, step_axes = STRAIGHT
    plan = program.solve(
        error, 0j, node_axes * turn, ZMP_BOUNDS, step_axes * turn, SHARES, STEP_BOUNDS
    )
    assert plan is not None
    return plan


def dcm_of(plan, omega: float = 3.0) -> complex:
    """ω ∫ exp(−ω t) d(t) dt + Σ γᵢ rᵢ, the integral by quadrature."""
    interval = ZmpStepMpc.interval(omega)
    t = np.linspace(0.0, NODES * interval, 20001)
    d = np.interp(t, interval * np.arange(NODES + 1), np.append(plan.zmp, 0.0))
    return complex(omega * np.trapezoid(np.exp(-omega * t) * d, t) + SHARES @ plan.footsteps)


@settings(max_examples=20, deadline=None)
@given(errors)
def test_plan_catches_the_dcm_error_within_soles_and_reach(error):
    plan = solve(ZmpStepMpc(STEPS), error)
    assert dcm_of(plan) + plan.missed == pytest.approx(error, abs=1e-4)
    assert np.abs(plan.zmp.real).max() <= HALF[0] + 1e-3
    assert np.abs(plan.zmp.imag).max() <= HALF[1] + 1e-3
    assert plan.footsteps.imag.min() >= -0.05 - 1e-3


def test_small_errors_are_the_soles_and_large_ones_move_the_next_footstep():
    small, large = (solve(ZmpStepMpc(STEPS), e) for e in (0.01 + 0.005j, 0.09 + 0.07j))
    assert np.abs(small.footsteps).max() < 1e-3
    assert large.footsteps[0].real > 0.01
    assert large.footsteps[0].imag > 0.03
    assert abs(large.missed) < 5e-3


def test_plan_turns_with_the_feet():
    turn = np.exp(0.7j)
    straight = solve(ZmpStepMpc(STEPS), 0.08 + 0.03j)
    turned = solve(ZmpStepMpc(STEPS), (0.08 + 0.03j) * turn, turn)
    np.testing.assert_allclose(turned.footsteps, straight.footsteps, atol=2e-4)
    np.testing.assert_allclose(turned.zmp, straight.zmp, atol=2e-3)


def test_cost_is_that_of_a_general_purpose_optimiser():
    error = 0.12
    program = ZmpStepMpc(STEPS)
    plan = solve(program, error)
    t = 4.0 / NODES * np.arange(NODES)  # times ω

    def cost(x: np.ndarray) -> float:
        d, r, missed = x[:NODES], x[NODES:-1], x[-1]
        change = np.diff(d, prepend=0.0)
        return float(
            np.exp(t) @ d**2 + 0.1 * change @ change + 100.0 * r @ r + 1e4 * missed * missed
        )

    hat = np.array([dcm_of(Plan(np.eye(NODES)[k])).real for k in range(NODES)])
    row = np.concatenate((hat, SHARES, [1.0]))
    best = minimize(
        cost,
        np.zeros(NODES + STEPS + 1),
        method="SLSQP",
        bounds=[(-HALF[0], HALF[0])] * NODES + [(-0.3, 0.3)] * STEPS + [(None, None)],
        constraints={"type": "eq", "fun": lambda x: row @ x - error},
        options={"maxiter": 500, "ftol": 1e-12},
    )
    assert best.success
    found = np.concatenate((plan.zmp.real, plan.footsteps.real, [plan.missed.real]))
    assert cost(found) == pytest.approx(cost(best.x), rel=0.01)


class Plan:
    """A plan with this ZMP and no displaced footstep."""

    def __init__(self, zmp: np.ndarray) -> None:
        self.zmp, self.footsteps = zmp, np.zeros(STEPS)


def test_what_nothing_catches_is_left_over():
    plan = solve(ZmpStepMpc(STEPS), 0.6)
    assert plan.missed.real > 0.1
    assert plan.footsteps[0].real == pytest.approx(0.3, abs=2e-3)


def test_a_copied_workspace_continues_bit_for_bit():
    program = ZmpStepMpc(STEPS)
    rng = np.random.default_rng(2)
    sequence = 0.08 * (rng.normal(size=8) + 0.5j * rng.normal(size=8))
    for error in sequence[:4]:
        solve(program, error)
    copies = [copy.deepcopy(program), pickle.loads(pickle.dumps(program))]
    for error in sequence[4:]:
        plan = solve(program, error)
        for other in copies:
            np.testing.assert_array_equal(solve(other, error).zmp, plan.zmp)
