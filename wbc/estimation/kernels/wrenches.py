"""The least squares of the wrench observer; see `wbc.estimation.wrench_observer`."""

from __future__ import annotations

import math

import numpy as np

from wbc.jit.compile import argument_types, kernel

_RIDGE = 1e-9  # of the largest diagonal entry, for a leg with fewer than six joints


@kernel(argument_types(np.zeros((1, 1)), *(np.zeros(1),) * 3, np.zeros((1, 1))))
def solve_wrenches(
    J: np.ndarray, residual: np.ndarray, weight: np.ndarray, wrenches: np.ndarray, work: np.ndarray
) -> None:
    """`F = argmin (Jᵀ F − r)ᵀ W (Jᵀ F − r)`, by the Cholesky factor of the normal equations.

    Args:
        J: (m, nv) stacked Jacobians of the soles.
        residual: (nv,) generalised force r that the soles have to explain.
        weight: (nv,) diagonal of W.
        wrenches: (m,) result F.
        work: (m, m) workspace.
    """
    m, nv = J.shape
    largest = 0.0
    for i in range(m):
        total = 0.0
        for k in range(nv):
            total += J[i, k] * weight[k] * residual[k]
        wrenches[i] = total
        for j in range(i + 1):
            total = 0.0
            for k in range(nv):
                total += J[i, k] * weight[k] * J[j, k]
            work[i, j] = total
        largest = max(largest, work[i, i])
    for i in range(m):
        work[i, i] += _RIDGE * largest
        for j in range(i + 1):
            total = work[i, j]
            for k in range(j):
                total -= work[i, k] * work[j, k]
            work[i, j] = math.sqrt(total) if i == j else total / work[j, j]
    for i in range(m):
        total = wrenches[i]
        for k in range(i):
            total -= work[i, k] * wrenches[k]
        wrenches[i] = total / work[i, i]
    for i in range(m - 1, -1, -1):
        total = wrenches[i]
        for k in range(i + 1, m):
            total -= work[k, i] * wrenches[k]
        wrenches[i] = total / work[i, i]
