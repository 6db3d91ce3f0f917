"""Tables of the results of trials."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from statistics import median

from wbc.cli.formatting import paragraph, table
from wbc.trials.comparison import Comparison
from wbc.trials.disturbance import direction_name
from wbc.trials.result import TrialResult
from wbc.trials.results import Results
from wbc.trials.survival import REQUIRED_SHARE, Case, Survival, differing_fields, survival_rates


def results_text(results: Results, rates: bool) -> str:
    """Return all tables of the results of a grid.

    Args:
        results: the results.
        rates: survival rates with their confidence intervals too.
    """
    grid = results.grid
    seeds = f"{len(grid.seeds)} seed{'s' if len(grid.seeds) > 1 else ''}"
    announced = announcements(results.trials)
    parts = [
        paragraph(
            f"{grid.name}: largest {grid.disturbance.kind}, {grid.disturbance.unit}, that is "
            f"survived in at least {100 * REQUIRED_SHARE:.0f} % of {grid.phases} phases × {seeds}, "
            "as all smaller ones are; + where it is the largest that was tried"
        ),
        survival_table(results),
        *([rates_table(results)] if rates else []),
        *([announced] if announced else []),
        "undisturbed",
        undisturbed_table(results.runs),
    ]
    crashed = [row for row in results.trials if row.crashed]
    if crashed:
        parts.append(f"{len(crashed)} trials ended with an error, e.g. {crashed[0].reason}")
    return "\n\n".join(parts)


def announcements(trials: Sequence[TrialResult]) -> str:
    """Return for each controller how many of its falls it announced, and how long before."""
    lines = []
    for controller in dict.fromkeys(row.controller for row in trials):
        falls = [
            (row.falling_at_s, row.fell_at_s)
            for row in trials
            if row.controller == controller and row.fell_at_s is not None
        ]
        before = [fell - announced for announced, fell in falls if announced is not None]
        lead = f", {median(before):.2f} s before at the median" if before else ""
        if falls:
            lines.append(f"{controller}: announced {len(before)} of {len(falls)} falls{lead}")
    return "\n".join(lines)


def falls_table(results: Results, most: int) -> str:
    """Return the falls with the smallest disturbances, with the keys of their trials."""
    falls = sorted((r for r in results.trials if not r.survived), key=lambda r: r.size or 0.0)
    if not falls:
        return "no falls"
    fields = differing_fields([Case.of(row) for row in results.trials])
    rows = [
        [
            row.key[:_KEY_LENGTH],
            *_labels(Case.of(row), fields),
            f"{row.seed}",
            f"{row.phase:.2f}",
            direction_name(row.direction_deg or 0.0),
            f"{row.size:g}",
            "–" if row.fell_at_s is None else f"{row.fell_at_s:.2f}",
            row.reason,
        ]
        for row in falls[:most]
    ]
    head = ["trial", *map(_title, fields), "seed", "phase", "direction", "size", "s", "reason"]
    return table(head, rows) + (f"\n{len(falls)} falls in all" if len(falls) > most else "")


def survival_table(results: Results) -> str:
    """Return the largest size that is survived, by case and direction."""
    rates = survival_rates(results.trials)
    cases = list(dict.fromkeys(one.case for one in rates))
    fields = differing_fields(cases)
    directions = list(dict.fromkeys(one.direction for one in rates))
    by_cell = {(one.case, one.direction): one for one in rates}
    head = [_title(name) for name in fields] + [direction_name(d) for d in directions]
    rows = [
        [
            *_labels(case, fields),
            *(_largest(by_cell.get((case, direction))) for direction in directions),
        ]
        for case in cases
    ]
    return table(head, rows, right=range(len(fields), len(head)))


def rates_table(results: Results) -> str:
    """Return the survival rate and its 95 % confidence interval, by case, direction and size."""
    rates = survival_rates(results.trials)
    fields = differing_fields([one.case for one in rates])
    rows = []
    for one in rates:
        for rate in one.rates:
            low, high = rate.interval()
            rows.append(
                [
                    *_labels(one.case, fields),
                    direction_name(one.direction),
                    f"{rate.size:g}",
                    f"{rate.survived}/{rate.trials}",
                    f"{100 * rate.share:.0f} %",
                    f"{100 * low:.0f} to {100 * high:.0f} %",
                ]
            )
    head = [*(_title(name) for name in fields), "direction", "size", "survived", "rate", "95 %"]
    return table(head, rows, right=range(len(fields) + 1, len(head)))


_KEY_LENGTH = 8  # characters of a key that are shown; enough to find it again


@dataclass(frozen=True, slots=True)
class _RunFigure:
    """A figure of undisturbed runs.

    Attributes:
        title: with its unit.
        form: format of the value.
        value: of a run; None if it has none.
    """

    title: str
    form: str
    value: Callable[[TrialResult], float | None]


_UNDISTURBED = (
    _RunFigure("steps/s", ".2f", lambda r: _per_second(r.steps, r)),
    _RunFigure("m/s", ".3f", lambda r: _per_second(r.distance_m, r)),
    _RunFigure("cost of transport", ".3f", lambda r: r.cost_of_transport),
    _RunFigure("rms N·m", ".1f", lambda r: r.torque_rms_nm),
    _RunFigure("peak torque", ".0%", lambda r: r.torque_peak),
    _RunFigure("landing/weight", ".2f", lambda r: r.landing_force_peak),
    _RunFigure("velocity error m/s", ".4f", lambda r: r.velocity_error_rms_m_s),
)


def undisturbed_table(runs: Sequence[TrialResult]) -> str:
    """Return the figures of the undisturbed runs, the mean over the seeds."""
    by_case = _by_case(runs)
    fields = differing_fields(list(by_case))
    rows = []
    for case, group in by_case.items():
        means = [(c.form, _mean(map(c.value, group))) for c in _UNDISTURBED]
        cells = ["–" if mean is None else format(mean, form) for form, mean in means]
        survived = f"{sum(r.survived for r in group)}/{len(group)}"
        rows.append([*_labels(case, fields), survived, *cells])
    head = [*map(_title, fields), "survived", *(column.title for column in _UNDISTURBED)]
    return table(head, rows, right=range(len(fields), len(head)))


def comparison_table(comparison: Comparison) -> str:
    """Return what either set survives, by case and direction, and the verdict on the second."""
    fields = differing_fields([cell.case for cell in comparison.cells])
    rows = [
        [
            *_labels(cell.case, fields),
            direction_name(cell.direction),
            f"{_largest(cell.first)} → {_largest(cell.second)}",
            f"{cell.better}",
            f"{cell.worse}",
            f"{cell.equal}",
            f"{cell.p_value:.3f}",
            cell.verdict.value,
        ]
        for cell in comparison.cells
    ]
    head = [*map(_title, fields), "direction", "largest", "better", "worse", "equal", "p", ""]
    return table(head, rows, right=range(len(fields) + 1, len(head) - 1))


def verdict(comparison: Comparison) -> str:
    """Return the verdict in words."""
    unpaired = f" {comparison.unpaired} trials are in one of them only." * (comparison.unpaired > 0)
    return paragraph(
        f"On the whole: {comparison.verdict.value}. Of the pairs of one phase and seed, "
        f"{comparison.better} survive more sizes in the second set, {comparison.worse} fewer, "
        f"{comparison.equal} as many (exact sign test, p = {comparison.p_value:.2g}; the cells "
        f"after Holm).{unpaired}"
    )


def change_table(first: Results, second: Results) -> str:
    """Return by how much the figures of the undisturbed runs change, in %."""
    before, after = _by_case(first.runs), _by_case(second.runs)
    single = all(len({case.controller for case in cases}) == 1 for cases in (before, after))
    if single:  # pair them by all but the controller
        (name,) = {case.controller for case in after}
        before = {replace(case, controller=name): group for case, group in before.items()}
    cases = [case for case in after if case in before]
    fields = differing_fields(cases)
    rows = [
        [*_labels(case, fields), *(_change(c, before[case], after[case]) for c in _UNDISTURBED)]
        for case in cases
    ]
    titles = (column.title.removesuffix(" m/s") for column in _UNDISTURBED)
    head = [*map(_title, fields), *titles]
    return table(head, rows, right=range(len(fields), len(head)))


def _change(column: _RunFigure, before: list[TrialResult], after: list[TrialResult]) -> str:
    old, new = (_mean(map(column.value, group)) for group in (before, after))
    return "–" if not old or new is None else f"{100.0 * (new / old - 1.0):+.1f} %"


def _by_case(runs: Sequence[TrialResult]) -> dict[Case, list[TrialResult]]:
    by_case: dict[Case, list[TrialResult]] = {}
    for row in runs:
        by_case.setdefault(Case.of(row), []).append(row)
    return by_case


def _per_second(value: float | None, run: TrialResult) -> float | None:
    return value / run.duration_s if value and run.duration_s else None


def _largest(one: Survival | None) -> str:
    if one is None:
        return "–"
    largest = one.largest_survived()
    return f"{largest:g}" + ("+" if largest == one.rates[-1].size else "")


def _title(field: str) -> str:
    return "motion" if field == "velocity" else field


def _labels(case: Case, fields: Sequence[str]) -> list[str]:
    return [case.motion if name == "velocity" else str(getattr(case, name)) for name in fields]


def _mean(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None
