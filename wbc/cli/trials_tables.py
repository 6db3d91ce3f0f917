"""Tables of the results of trials."""

from __future__ import annotations

from collections.abc import Sequence

from wbc.cli.formatting import table
from wbc.trials.disturbance import direction_name
from wbc.trials.result import TrialResult
from wbc.trials.results import Results
from wbc.trials.survival import Case, Survival, differing_fields, survival_rates


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


def undisturbed_table(runs: Sequence[TrialResult]) -> str:
    """Return the figures of the undisturbed runs, the mean over the seeds."""
    by_case: dict[Case, list[TrialResult]] = {}
    for row in runs:
        by_case.setdefault(Case.of(row), []).append(row)
    fields = differing_fields(list(by_case))
    rows = []
    for case, group in by_case.items():
        cadence = [r.steps / r.duration_s for r in group if r.steps and r.duration_s]
        speed = [r.distance_m / r.duration_s for r in group if r.distance_m and r.duration_s]
        rows.append(
            [
                *_labels(case, fields),
                f"{sum(r.survived for r in group)}/{len(group)}",
                _mean(cadence, "{:.2f}"),
                _mean(speed, "{:.3f}"),
                _mean([r.cost_of_transport for r in group], "{:.3f}"),
                _mean([r.torque_rms_nm for r in group], "{:.1f}"),
                _mean([r.torque_peak for r in group], "{:.0%}"),
                _mean([r.landing_force_peak for r in group], "{:.2f}"),
                _mean([r.velocity_error_rms_m_s for r in group], "{:.4f}"),
            ]
        )
    head = [
        *(_title(name) for name in fields),
        "survived", "steps/s", "m/s", "CoT", "rms N·m", "peak torque", "landing/weight",
        "velocity error m/s",
    ]  # fmt: skip
    return table(head, rows, right=range(len(fields), len(head)))


def _largest(one: Survival | None) -> str:
    if one is None:
        return "–"
    largest = one.largest_survived()
    return f"{largest:g}" + ("+" if largest == one.rates[-1].size else "")


def _title(field: str) -> str:
    return "motion" if field == "velocity" else field


def _labels(case: Case, fields: Sequence[str]) -> list[str]:
    return [case.motion if name == "velocity" else str(getattr(case, name)) for name in fields]


def _mean(values: Sequence[float | None], form: str) -> str:
    known = [value for value in values if value is not None]
    return form.format(sum(known) / len(known)) if known else "–"
