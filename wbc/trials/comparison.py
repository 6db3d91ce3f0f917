"""Compares two sets of results, trial by trial, with a verdict."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import Enum

from wbc.trials.errors import TrialError
from wbc.trials.result import TrialResult
from wbc.trials.results import Results
from wbc.trials.survival import Case, Survival, survival_rates

SIGNIFICANCE = 0.05  # probability of a verdict without any difference, over all cells together

#: Phase and seed: one situation, in which the trials differ by size alone.
_Situation = tuple[float | None, int]


class Verdict(Enum):
    """The verdict on the second of two sets of results."""

    BETTER = "better"
    WORSE = "worse"
    NO_DIFFERENCE = "no difference shown"


@dataclass(frozen=True, slots=True)
class CellComparison:
    """The comparison of one case and direction.

    Trials of one phase and seed that differ by size alone are no independent samples. They count as
    one: the result in which more sizes are survived is the better one. Whether better ones outweigh
    is judged by the exact sign test (with two outcomes per sample McNemar's; Psychometrika 12,
    1947): the probability, without a difference, of a count as uneven as this.

    Attributes:
        case: robot, controller of the second set, velocity and condition.
        direction: degrees counter-clockwise from the robot's heading.
        first: survival in the first set, of the trials in both.
        second: likewise in the second set.
        better: number of phases and seeds in which the second set survives more sizes.
        worse: likewise fewer.
        equal: likewise as many.
        p_value: of the sign test, two-sided.
        verdict: at `SIGNIFICANCE` over all cells together (Holm, Scand. J. Stat. 6, 1979).
    """

    case: Case
    direction: float
    first: Survival
    second: Survival
    better: int
    worse: int
    equal: int
    p_value: float
    verdict: Verdict = Verdict.NO_DIFFERENCE


@dataclass(frozen=True, slots=True)
class Comparison:
    """The comparison of two sets of results.

    Attributes:
        cells: of each case and direction.
        better: number of situations in which the second set survives more sizes, over all cells.
        worse: likewise fewer.
        equal: likewise as many.
        p_value: of the sign test over all cells, two-sided.
        verdict: at `SIGNIFICANCE`.
        unpaired: number of trials that are in one set only.
    """

    cells: tuple[CellComparison, ...]
    better: int
    worse: int
    equal: int
    p_value: float
    verdict: Verdict
    unpaired: int

    @property
    def any_worse(self) -> bool:
        """Whether the second set is worse on the whole or in any cell."""
        verdicts = [self.verdict, *(cell.verdict for cell in self.cells)]
        return Verdict.WORSE in verdicts


def compare(first: Results, second: Results) -> Comparison:
    """Compare results trial by trial: same robot, velocity, condition, seed, phase and push.

    If both sets have one controller each, these are compared; else those of the same name.

    Raises:
        TrialError: the sets have no trial in common.
    """
    rows, others = _by_pair(first, second), _by_pair(second, first)
    common = [pair for pair in others if pair in rows]
    if not common:
        raise TrialError(
            "the results have no trial in common: robot, velocity, condition, seed, phase, "
            "direction and size must be the same, and the controllers' names if there are several"
        )
    cells: dict[tuple[Case, float], list[tuple[TrialResult, TrialResult]]] = {}
    for pair in common:
        row, other = rows[pair], others[pair]
        assert other.direction_deg is not None
        cells.setdefault((Case.of(other), other.direction_deg), []).append((row, other))
    compared = [_compare_cell(case, d, pairs) for (case, d), pairs in cells.items()]
    better, worse, equal = (
        sum(getattr(cell, name) for cell in compared) for name in ("better", "worse", "equal")
    )
    p_value = sign_test(better, worse)
    return Comparison(
        tuple(_with_verdicts(compared)),
        better,
        worse,
        equal,
        p_value,
        _verdict(better, worse, p_value <= SIGNIFICANCE),
        len(rows) + len(others) - 2 * len(common),
    )


def sign_test(better: int, worse: int) -> float:
    """Return the probability of a count at least as uneven if both were equally probable."""
    from scipy.stats import binomtest

    return float(binomtest(better, better + worse).pvalue) if better + worse else 1.0


def _by_pair(results: Results, other: Results) -> dict[tuple[object, ...], TrialResult]:
    """Return trials by what makes them comparable with those of the other set."""
    single = all(len({row.controller for row in one.trials}) == 1 for one in (results, other))
    return {
        (
            row.robot,
            "" if single else row.controller,
            Case.of(row).velocity,
            row.condition,
            row.seed,
            row.disturbance,
            row.phase,
            row.direction_deg,
            row.size,
        ): row
        for row in results.trials
    }


def _compare_cell(
    case: Case, direction: float, pairs: Iterable[tuple[TrialResult, TrialResult]]
) -> CellComparison:
    pairs = list(pairs)
    differences: dict[_Situation, int] = {}
    for row, other in pairs:
        situation = (row.phase, row.seed)
        more = int(other.survived) - int(row.survived)
        differences[situation] = differences.get(situation, 0) + more
    better = sum(more > 0 for more in differences.values())
    worse = sum(more < 0 for more in differences.values())
    (first,), (second,) = (survival_rates(rows) for rows in zip(*pairs, strict=True))
    equal = len(differences) - better - worse
    p_value = sign_test(better, worse)
    return CellComparison(case, direction, first, second, better, worse, equal, p_value)


def _with_verdicts(cells: list[CellComparison]) -> list[CellComparison]:
    """Return the cells with verdicts: Holm's step-down over their p-values."""
    found: dict[int, Verdict] = {}
    ordered = sorted(cells, key=lambda cell: cell.p_value)
    for rank, cell in enumerate(ordered):
        if cell.p_value > SIGNIFICANCE / (len(cells) - rank):
            break
        found[id(cell)] = _verdict(cell.better, cell.worse, True)
    return [replace(c, verdict=found.get(id(c), Verdict.NO_DIFFERENCE)) for c in cells]


def _verdict(better: int, worse: int, significant: bool) -> Verdict:
    if not significant:
        return Verdict.NO_DIFFERENCE
    return Verdict.BETTER if better > worse else Verdict.WORSE
