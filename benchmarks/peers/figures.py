"""Statistics of the measured ticks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Figures:
    """Of one library on one case; µs.

    Attributes:
        p50: median over all ticks of all passes.
        p99: likewise, nothing filtered.
        max: the longest.
        p99_of_ticks: 99th percentile over the ticks of each tick's own median over the passes:
            what the hardest problems take, without what disturbs one pass in two or fewer.
    """

    p50: float
    p99: float
    max: float
    p99_of_ticks: float


def figures(times: np.ndarray) -> Figures:
    """Of times (passes, ticks) in ns."""
    micro = times / 1e3
    return Figures(
        p50=float(np.median(micro)),
        p99=float(np.percentile(micro, 99)),
        max=float(micro.max()),
        p99_of_ticks=float(np.percentile(np.median(micro, axis=0), 99)),
    )


@dataclass(frozen=True)
class Ratio:
    """Ours over a peer; below 1, ours is faster.

    Attributes:
        p50: of the medians over everything.
        p99: of the 99th percentiles over everything.
        p99_of_ticks: see `Figures`.
        rounds: of the medians, round by round.
    """

    p50: float
    p99: float
    p99_of_ticks: float
    rounds: tuple[float, ...]

    @property
    def median_of_rounds(self) -> float:
        """The middle one of the rounds' ratios."""
        return float(np.median(self.rounds))


def ratio(ours: Sequence[np.ndarray], theirs: Sequence[np.ndarray]) -> Ratio:
    """Of times per round, each (passes, ticks)."""
    a, b = figures(np.concatenate(ours)), figures(np.concatenate(theirs))
    return Ratio(
        p50=a.p50 / b.p50,
        p99=a.p99 / b.p99,
        p99_of_ticks=a.p99_of_ticks / b.p99_of_ticks,
        rounds=tuple(float(np.median(x) / np.median(y)) for x, y in zip(ours, theirs, strict=True)),
    )
