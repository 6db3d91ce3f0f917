"""The quadratic program of the model-predictive planner: ZMP and footsteps that catch a DCM."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

NODES = 24  # of the ZMP, at constant distances in time
_HORIZON = 4.0  # time from the first node to the one after the last times ω: e^(−4) is 2 %
# Weights of squared lengths: ZMP off its path, its change from node to node, a footstep off its
# planned place relative to the one before it, and a DCM that is not caught.
_ZMP, _RATE, _FOOTSTEP, _MISSED = 1.0, 0.1, 100.0, 1e4
_GROWTH = 1.0  # rate of the weight of the ZMP over time, divided by ω: what is early is cheaper
_SETTINGS = {
    "verbose": False,
    "scaling": 0,  # done here: a workspace that is set up anew has to behave as the old one
    "adaptive_rho": 0,
    "rho": 10.0,
    "eps_abs": 1e-4,  # m
    "eps_rel": 1e-4,
    "max_iter": 1000,
    "check_termination": 10,
}


@dataclass(slots=True)
class ZmpStepPlan:
    """Solution of `ZmpStepMpc`, in the axes of the first support sole.

    Attributes:
        zmp: (NODES,) complex, differences of the ZMP from its planned path, m.
        footsteps: (steps,) complex, displacements of the footsteps, each relative to the one
            before it, m.
        missed: part of the DCM error that nothing catches, m.
    """

    zmp: np.ndarray
    footsteps: np.ndarray
    missed: complex


class ZmpStepMpc:
    """Linear model-predictive control of the DCM by ZMP and footsteps.

    A DCM that is off its plan by e stays bounded if ZMP and footsteps leave theirs by d(t) and
    rᵢ such that (Scianca et al., MPC for humanoid gait generation: stability and feasibility,
    T-RO 2020, whose footsteps and moving ZMP bounds these are as well)

        ω ∫₀^∞ exp(−ω t) d(t) dt + Σ γᵢ rᵢ = e,

    γᵢ the share that the weight on the i-th and later footsteps has in the DCM. d is linear
    between nodes and zero after the last; it stays on a sole that moves along with the planned
    ZMP, the footsteps within the reach of the legs. Minimised is

        Σ exp(ω t_k) |d_k|² + 0.1 Σ |d_k − d_(k−1)|² + 100 Σ |rᵢ|²,

    so that the ZMP acts early, and footsteps move when the soles do not suffice; what cannot be
    caught is left over at a high price (after Herdt et al., Online walking motion generation with
    automatic footstep placement, Advanced Robotics 2010). One workspace of OSQP is set up once and
    updated in place.

    Args:
        steps: number of footsteps.
    """

    def __init__(self, steps: int) -> None:
        zmp, feet = 2 * NODES, 2 * steps
        self._zmp, self._footsteps = slice(0, zmp), slice(zmp, zmp + feet)
        self._size = size = zmp + feet + 2
        h = _HORIZON / NODES
        # ω ∫ exp(−ω t) over the hat function of each node.
        self._zmp_shares = np.exp(-h * np.arange(NODES)) * (2.0 * np.cosh(h) - 2.0) / h
        self._zmp_shares[0] = 1.0 - (1.0 - np.exp(-h)) / h
        weights = np.repeat([_ZMP, _FOOTSTEP, _MISSED], [zmp, feet, 2])
        weights[self._zmp] *= np.exp(_GROWTH * h * np.repeat(np.arange(NODES), 2))
        # OSQP's variables are lengths divided by this: its Hessian is close to the identity.
        self._scale = 1.0 / np.sqrt(weights)
        self._x, self._y = np.zeros(size), np.zeros(size)
        self._solver: Any = None
        self._set_up(np.zeros(size), np.zeros(size), np.zeros(size), np.ones(3 * size - 2))

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy needs: it sets its workspace up anew, and starts it as this one's."""
        return {**self.__dict__, "_solver": None}

    @staticmethod
    def interval(omega: float) -> float:
        """Return the time between two nodes, s."""
        return _HORIZON / (NODES * omega)

    def solve(
        self,
        error: complex,
        last_zmp: complex,
        node_axes: np.ndarray,
        zmp_bounds: np.ndarray,
        step_axes: np.ndarray,
        step_shares: np.ndarray,
        step_bounds: np.ndarray,
    ) -> ZmpStepPlan | None:
        """Solve the program; None if OSQP does not.

        Args:
            error: e, in the axes of the first support sole, m.
            last_zmp: d at this time as it was planned before, m.
            node_axes: (NODES,) exp(iθ) of the sole's heading θ at each node.
            zmp_bounds: (2, 2 NODES) least and most x₀, y₀, x₁, … of d in these axes, m.
            step_axes: (steps,) exp(iθ) of the heading of the foot from which each step is made.
            step_shares: (steps,) γᵢ.
            step_bounds: (2, 2 steps) least and most x₁, y₁, x₂, … of rᵢ in these axes, m.
        """
        size, scale = self._size, self._scale
        shares = np.concatenate(
            (self._zmp_shares * node_axes, step_shares * step_axes, (1.0 + 0j,))
        )
        columns = np.empty((size, 3))  # both rows of the equation, then the bound
        columns[::2, 0], columns[::2, 1] = shares.real, shares.imag
        columns[1::2, 0], columns[1::2, 1] = -shares.imag, shares.real
        columns[:, :2] *= scale[:, None]
        columns[:, 2] = 1.0
        lower, upper = np.empty(size), np.empty(size)
        lower[:2] = upper[:2] = error.real, error.imag
        bounds = np.concatenate((zmp_bounds, step_bounds), axis=1) / scale[:-2]
        lower[2:], upper[2:] = bounds
        q = np.zeros(size)
        q[:2] = -_RATE * scale[0] * last_zmp.real, -_RATE * scale[1] * last_zmp.imag
        # What is missed has no bounds.
        values = np.concatenate((columns[:-2].ravel(), columns[-2:, :2].ravel()))
        return self._solution(q, lower, upper, values)

    def _solution(
        self, q: np.ndarray, lower: np.ndarray, upper: np.ndarray, values: np.ndarray
    ) -> ZmpStepPlan | None:
        if self._solver is None:
            self._set_up(q, lower, upper, values)
        else:
            self._solver.update(q=q, l=lower, u=upper, Ax=values)
        self._solver.warm_start(x=self._x, y=self._y)
        result = self._solver.solve(raise_error=False)
        x = np.asarray(result.x)
        if result.info.status_val not in (1, 2) or not np.isfinite(x).all():
            self._x[:], self._y[:], self._solver = 0.0, 0.0, None
            return None
        self._x, self._y = x.copy(), np.array(result.y)
        points = (x * self._scale).view(complex)
        return ZmpStepPlan(points[:NODES], points[NODES:-1], complex(points[-1]))

    def _set_up(
        self, q: np.ndarray, lower: np.ndarray, upper: np.ndarray, values: np.ndarray
    ) -> None:
        import osqp
        from scipy import sparse

        size, scale = self._size, self._scale[self._zmp]
        change = sparse.diags([scale, -scale[:-2]], [0, -2])
        P = sparse.identity(size, format="lil")
        P[self._zmp, self._zmp] += _RATE * change.T @ change
        P = sparse.triu(P, format="csc")
        rows = [row for j in range(size - 2) for row in (0, 1, 2 + j)] + [0, 1, 0, 1]
        starts = [*range(0, values.size - 3, 3), values.size - 2, values.size]
        A = sparse.csc_matrix((values, rows, starts), shape=(size, size))
        self._solver = osqp.OSQP()
        self._solver.setup(P, q, A, lower, upper, **_SETTINGS)
