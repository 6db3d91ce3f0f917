"""What a sole carries, and whether it stands; see `wbc.estimation.contact`."""

from __future__ import annotations

import math

import numpy as np

from wbc.jit.compile import argument_types, kernel

#: Thresholds of `read_load`: a `ContactTrigger` and the robot's weight.
LOAD_LIMITS = np.dtype(
    [("on", float), ("off", float), ("full", float), ("weight", float)], align=True
)

_LEAST = 0.02  # share of the weight; with less, a sole is trusted no less


@kernel(argument_types(np.zeros(6), np.zeros(1, LOAD_LIMITS), True, np.zeros(1), 0))
def read_load(
    wrench: np.ndarray, limits: np.ndarray, stood: bool, slip: np.ndarray, foot: int
) -> tuple[float, bool]:
    """Return the load of a sole, a share of the robot's weight, and whether it stands.

    Args:
        wrench: (6,) from the ground, sole axes; N, N·m.
        limits: (1,) of the type `LOAD_LIMITS`; shares of the weight, and the weight, N.
        stood: whether the sole stood until now.
        slip: (feet,) result: at `foot`, the factor on the drift of a sole that stood; 0 for another
            one.
        foot: index of the sole.

    Returns:
        NaN as the load, unless the wrench is six finite numbers.
    """
    limit = limits[0]
    if wrench.ndim != 1 or wrench.size != 6:
        return math.nan, stood
    total = 0.0
    for i in range(6):
        total += abs(wrench[i])
    if not total < math.inf:
        return math.nan, stood
    load, full = wrench[2] / limit["weight"], limit["full"]
    slip[foot] = 0.0
    if stood:
        slip[foot] = 1.0 if load >= full else max(1.0, full / max(load, _LEAST))
    return load, bool(load > (limit["off"] if stood else limit["on"]))
