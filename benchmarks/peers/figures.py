"""Statistics of the measured ticks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Figures:
    """Times of one library on one case, µs.

    Attributes:
        p50: median over all ticks of all passes.
        p99: 99th percentile likewise, without filtering.
        max: longest tick.
        p99_of_ticks: 99th percentile over the ticks of each tick's median over the passes: the
            time of the hardest problems without occasional disturbances.
    """

    p50: float
    p99: float
    max: float
    p99_of_ticks: float


def figures(times: np.ndarray) -> Figures:
    """Return the figures of times, ns, shape (passes, ticks)."""
    micro = times / 1e3
    return Figures(
        p50=float(np.median(micro)),
        p99=float(np.percentile(micro, 99)),
        max=float(micro.max()),
        p99_of_ticks=float(np.percentile(np.median(micro, axis=0), 99)),
    )


@dataclass(frozen=True)
class Ratio:
    """Our time over a peer's; below 1, ours is faster.

    Attributes:
        p50: ratio of the medians over all rounds.
        p99: ratio of the 99th percentiles over all rounds.
        p99_of_ticks: ratio of `Figures.p99_of_ticks`.
        rounds: ratios of the medians of each round.
    """

    p50: float
    p99: float
    p99_of_ticks: float
    rounds: tuple[float, ...]

    @property
    def median_of_rounds(self) -> float:
        """Median of the rounds' ratios."""
        return float(np.median(self.rounds))


def ratio(ours: Sequence[np.ndarray], theirs: Sequence[np.ndarray]) -> Ratio:
    """Return the ratio of times of each round, ns, each of shape (passes, ticks)."""
    a, b = figures(np.concatenate(ours)), figures(np.concatenate(theirs))
    return Ratio(
        p50=a.p50 / b.p50,
        p99=a.p99 / b.p99,
        p99_of_ticks=a.p99_of_ticks / b.p99_of_ticks,
        rounds=tuple(float(np.median(x) / np.median(y)) for x, y in zip(ours, theirs, strict=True)),
    )
