"""The screening of gains finds the factors that decide, among those that do not."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
import screening

import wbc
from wbc.trials.tour import draw_tour


def tours(seed, planted, n=1500):
    """Short tours whose falls per punch depend on the levels of some factors."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(n):
        levels = rng.choice((-1, 1), len(screening.NAMES))
        risk = 0.06 * np.exp(sum(b * levels[k] for k, b in planted.items()))
        falls = np.flatnonzero(rng.random(5) < risk)
        punches = int(falls[0]) + 1 if len(falls) else 5
        found.append(screening.Outcome(tuple(levels.tolist()), punches, len(falls) > 0))
    return found


@pytest.mark.parametrize("seed", range(5))
def test_the_factors_that_decide_come_first_with_their_ratio_in_the_interval(seed):
    planted = {3: np.log(1.3), 17: -np.log(1.4)}
    outcomes = tours(seed, planted)
    found = screening.effects(outcomes)
    first = found[:2]
    assert {effect.name for effect in first} == {screening.NAMES[k] for k in planted}
    for effect in first:
        true = np.exp(2.0 * planted[screening.NAMES.index(effect.name)])
        assert np.sign(effect.ratio - 1.0) == np.sign(true - 1.0)
        # Three standard errors: the interval has two.
        width = np.log(effect.interval[1] / effect.ratio)
        assert abs(np.log(true / effect.ratio)) < 1.5 * width
    for effect in found:
        (low_falls, low), (high_falls, high) = effect.low, effect.high
        assert low_falls + high_falls == sum(outcome.fell for outcome in outcomes)
        assert low + high == sum(outcome.punches for outcome in outcomes)


def test_of_factors_without_effect_about_one_in_twenty_is_outside_of_its_interval():
    outside = [
        not effect.interval[0] < 1.0 < effect.interval[1]
        for seed in range(6)
        for effect in screening.effects(tours(100 + seed, {}))
    ]
    assert 0.0 < np.mean(outside) < 0.1
    assert len(outside) == 6 * len(screening.NAMES)


def test_the_levels_tell_nothing_of_the_punches_of_their_tour():
    robot = wbc.load("g1_tour")
    seeds = range(40000, 40300)
    levels = np.array([screening.draw_levels(seed) for seed in seeds])
    punches = [draw_tour(robot, seed).punches[:2] for seed in seeds]
    drawn = np.array([[[*p.force, robot.joint_index(p.joint)] for p in two] for two in punches])
    found = np.corrcoef(levels.T, drawn.reshape(len(seeds), -1).T)
    between = np.abs(found[: levels.shape[1], levels.shape[1] :])
    assert between.max() < 4.5 / np.sqrt(len(seeds))


def test_a_short_tour_runs_at_the_levels_of_its_seed_and_is_the_same_again(monkeypatch):
    pytest.importorskip("mujoco")
    monkeypatch.setattr(screening, "_SEGMENTS", 1)
    first = screening.run("g1_tour", 1.0, 40001)
    assert first == screening.run("g1_tour", 1.0, 40001)
    assert first.punches == 1
    assert set(first.levels) == {-1, 1}
    assert first.levels != screening.run("g1_tour", 1.0, 40002).levels
