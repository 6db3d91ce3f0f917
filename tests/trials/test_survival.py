"""Survival rates, comparisons with a verdict, and plots, from made-up results."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binomtest
from trialtools import made_up

from wbc.errors import MissingExtra
from wbc.trials import (
    ControllerSpec,
    TrialError,
    Verdict,
    compare,
    plot_results,
    survival_rates,
)
from wbc.trials.comparison import sign_test
from wbc.trials.survival import SurvivalRate


def test_the_largest_size_survived_counts_only_if_all_smaller_ones_are():
    results = made_up(0.5, spread=0.0)
    assert {one.largest_survived() for one in survival_rates(results.trials)} == {0.4}
    weak_spot = [
        replace(row, survived=False) if row.size == 0.2 and row.direction_deg == 90.0 else row
        for row in results.trials
    ]
    largest = {one.direction: one.largest_survived() for one in survival_rates(weak_spot)}
    assert largest == {0.0: 0.4, 90.0: 0.0, 180.0: 0.4, 270.0: 0.4}


def test_nineteen_of_twenty_are_enough():
    rows = made_up(0.5, spread=0.0).trials
    one = survival_rates(rows[:1])[0]
    assert replace(one, rates=(SurvivalRate(0.2, 19, 20),)).largest_survived() == 0.2
    assert replace(one, rates=(SurvivalRate(0.2, 18, 20),)).largest_survived() == 0.0


@pytest.mark.parametrize(("survived", "trials"), [(0, 5), (3, 5), (28, 30), (30, 30)])
def test_the_interval_is_wilsons(survived, trials):
    z, n = 1.959963984540054, trials
    p = survived / n
    centre = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    interval = SurvivalRate(0.2, survived, trials).interval()
    assert interval == pytest.approx((max(centre - half, 0.0), min(centre + half, 1.0)), abs=1e-9)


def test_the_sign_test_is_exact():
    assert sign_test(0, 0) == 1.0
    assert sign_test(9, 1) == pytest.approx(binomtest(9, 10).pvalue)
    assert sign_test(6, 0) == pytest.approx(2 * 0.5**6)


def test_a_controller_that_survives_more_is_better_and_the_other_way_round():
    weak, strong = made_up(0.3, spread=0.0), made_up(0.7, spread=0.0, draw=1)
    forth, back = compare(weak, strong), compare(strong, weak)
    assert (forth.verdict, back.verdict) == (Verdict.BETTER, Verdict.WORSE)
    assert {cell.verdict for cell in forth.cells} == {Verdict.BETTER}
    assert back.any_worse
    assert not forth.any_worse
    # Four phases, three seeds: twelve pushes per cell, whatever the number of sizes.
    assert {(cell.better, cell.worse, cell.equal) for cell in forth.cells} == {(12, 0, 0)}


def test_luck_is_no_difference():
    verdicts = [
        compare(made_up(0.5, 0.15, draw), made_up(0.5, 0.15, draw + 100)).any_worse
        for draw in range(10)
    ]
    assert sum(verdicts) <= 2


def test_one_worse_cell_is_named_even_if_the_whole_is_no_worse():
    before = made_up(0.5, spread=0.0)
    rows = [
        replace(row, survived=False, reason="made up", fell_at_s=0.1)
        if row.direction_deg == 90.0 and row.velocity_forward == 0.3
        else replace(row, survived=True)
        for row in before.rows
    ]
    comparison = compare(before, replace(before, rows=tuple(rows)))
    worse = [cell for cell in comparison.cells if cell.verdict is Verdict.WORSE]
    assert [(cell.direction, cell.case.velocity[0]) for cell in worse] == [(90.0, 0.3)]
    assert comparison.verdict is Verdict.BETTER
    assert comparison.any_worse


def test_only_trials_of_both_are_compared():
    whole = made_up(0.5)
    half = made_up(0.5, controllers=(ControllerSpec("other"),))
    half = replace(half, rows=tuple(row for row in half.rows if row.size != 0.8))
    comparison = compare(whole, half)
    assert comparison.unpaired == len([row for row in whole.trials if row.size == 0.8])
    assert {rate.size for cell in comparison.cells for rate in cell.first.rates} == {0.2, 0.4, 0.6}
    with pytest.raises(TrialError, match="no trial in common"):
        compare(whole, replace(half, rows=()))


@pytest.mark.parametrize("directions", [("left", "right"), (0, 45, 90, 135, 180, 225, 270, 315)])
def test_plots_are_drawn(tmp_path, directions):
    results = made_up(
        0.5,
        directions=directions,
        controllers=(ControllerSpec("a"), ControllerSpec("b", options={"recovery": False})),
    )
    paths = plot_results(results, tmp_path / "new", "grid")
    assert [path.name for path in paths] == ["grid_push_map.png", "grid_survival.png"]
    for path in paths:
        assert path.stat().st_size > 20_000


def test_plots_of_nothing_are_refused(tmp_path):
    results = made_up(0.5)
    with pytest.raises(TrialError, match="no trials to plot"):
        plot_results(replace(results, rows=results.runs), tmp_path, "grid")


def test_missing_packages_are_named_with_their_extra(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    with pytest.raises(MissingExtra, match=r"pip install 'wbc\[trials\]'"):
        made_up(0.5).to_arrow()
