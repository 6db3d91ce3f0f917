"""Shows which gains decide whether a robot survives the tour's punches, all varied at once.

In each short tour (`wbc trials tour`) at full force every factor, a field of `WalkerGains` or of
the quick steps' `GaitParameters`, is at its low or at its high level, by the toss of a coin. So all
tours tell of all factors (a two-level screening design), where a comparison of one change at a time
needs as many for each: punches are survived or not by chance, and a change that acts in most of
them changes one outcome in ten, either way. With the falls y of a tour (0 or 1), the number n of
its punches and the levels x = ±1, the model is

    y ~ Poisson(n exp(b_0 + Σ b_k x_k)),

fitted with a weak prior on the b_k (McCullagh and Nelder, Generalized linear models, 1989).
Printed are the ratio of the falls per punch at the high level to those at the low one,
`exp(2 b_k)`, its 95 % interval, and the falls over the punches of both. Of twenty factors without
any effect one is outside of its interval.

The tours are those from seed 40000 on: no table of the tour uses them.

    python benchmarks/screening.py
    python benchmarks/screening.py --tours 100 --robot g1
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import dataclasses
import functools
import json
import math
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

import wbc
from wbc.gait import GaitParameters
from wbc.trials.tour import TourParameters, draw_tour, run_tour
from wbc.walking import WalkerGains

_DT = 0.002  # s
_FIRST_SEED = 40000
_LEVELS = 3  # random stream of a seed; the tour draws from streams 0 to 2
_SEGMENTS = 5  # punches of a tour
_SEGMENT = 5.0  # s
_PRIOR = 8.0  # 1/variance of the b_k
_ITERATIONS = 30  # of Newton's method

_Fields = TypeVar("_Fields", WalkerGains, GaitParameters)


@dataclass(frozen=True)
class Factor:
    """A field that is varied.

    Attributes:
        field: its name.
        low: factor on its value, low level.
        high: the same, high level.
    """

    field: str
    low: float
    high: float


GAINS = (
    Factor("com_weight", 0.67, 1.5),
    Factor("height_kp", 0.7, 1.43),
    Factor("swing_recovery_share", 0.7, 1.45),
    Factor("swing_recovery_turn_share", 0.45, 2.1),
    Factor("trunk_kp", 0.77, 1.3),
    Factor("trunk_recovery_share", 0.67, 1.5),
    Factor("torso_release_angle", 0.67, 1.5),
    Factor("tipping_distance", 0.77, 1.3),
    Factor("tipping_weight", 0.4, 2.5),
    Factor("posture_weight", 0.6, 1.7),
    Factor("leg_posture_weight", 0.5, 2.0),
    Factor("knee_posture_weight", 0.5, 2.0),
    Factor("second_contact_weight", 0.57, 1.77),
    Factor("friction", 0.87, 1.17),
    Factor("zmp_margin", 0.4, 2.25),
    Factor("ankle_share", 0.72, 1.4),
)
QUICK_STEPS = (
    Factor("single_support", 0.92, 1.09),
    Factor("double_support", 0.3, 2.2),
    Factor("max_step", 0.88, 1.12),
    Factor("max_side_step", 0.88, 1.12),
    Factor("least_width", 0.94, 1.06),
    Factor("swing_height", 0.8, 1.25),
    Factor("dcm_gain", 0.65, 1.5),
)
_FACTORS = (*GAINS, *QUICK_STEPS)
NAMES = (
    *(factor.field for factor in GAINS),
    *(f"quick steps: {factor.field}" for factor in QUICK_STEPS),
)


@dataclass(frozen=True)
class Outcome:
    """A short tour.

    Attributes:
        levels: of the factors, ±1, in the order of `NAMES`.
        punches: until its end or the fall.
        fell: whether the robot fell.
    """

    levels: tuple[int, ...]
    punches: int
    fell: bool


@dataclass(frozen=True)
class Effect:
    """What a factor does.

    Attributes:
        name: of the factor.
        levels: of the factor, low and high, as factors on its value.
        ratio: of the falls per punch, high to low level.
        interval: 95 % interval of the ratio.
        low: falls and punches at the low level.
        high: the same at the high level.
    """

    name: str
    levels: tuple[float, float]
    ratio: float
    interval: tuple[float, float]
    low: tuple[int, int]
    high: tuple[int, int]


def run(name: str, friction: float, seed: int) -> Outcome:
    """Run a short tour with levels drawn from its seed."""
    robot = wbc.load(name)
    levels = draw_levels(seed)
    gains = WalkerGains.for_robot(robot)
    quick = GaitParameters.for_recovery(robot, GaitParameters.for_robot(robot))
    walker = wbc.Walker(
        robot,
        _DT,
        gains=_at_levels(gains, GAINS, levels[: len(GAINS)]),
        recovery_gait=_at_levels(quick, QUICK_STEPS, levels[len(GAINS) :]),
    )
    parameters = TourParameters(
        duration=_SEGMENT * _SEGMENTS, waypoints=_SEGMENTS, first_force=1.0, friction=friction
    )
    tour = draw_tour(robot, seed, parameters)
    result = run_tour(robot, walker, tour)
    hit = [punch for punch in tour.punches if punch.time <= result.survived]
    return Outcome(levels, len(hit), not result.completed)


def draw_levels(seed: int) -> tuple[int, ...]:
    """Return the levels of a tour, ±1: independent of its waypoints, punches and arms."""
    return tuple(np.random.default_rng((seed, _LEVELS)).choice((-1, 1), len(NAMES)).tolist())


def _at_levels(base: _Fields, factors: tuple[Factor, ...], levels: tuple[int, ...]) -> _Fields:
    """Return `base` with its factors at their levels."""
    changed = {
        factor.field: getattr(base, factor.field) * (factor.high if level > 0 else factor.low)
        for factor, level in zip(factors, levels, strict=True)
    }
    return dataclasses.replace(base, **changed)


def fit(outcomes: list[Outcome]) -> tuple[np.ndarray, np.ndarray]:
    """Return the b_k of all factors and their standard errors; see above."""
    levels = np.array([(1, *o.levels) for o in outcomes], float)
    punches = np.array([o.punches for o in outcomes], float)
    falls = np.array([o.fell for o in outcomes], float)
    prior = np.full(levels.shape[1], _PRIOR)
    prior[0] = 0.0
    b = np.zeros(levels.shape[1])
    b[0] = np.log(falls.sum() / punches.sum())
    for _ in range(_ITERATIONS):
        expected = punches * np.exp(levels @ b)
        hessian = levels.T @ (levels * expected[:, None]) + np.diag(prior)
        b += np.linalg.solve(hessian, levels.T @ (falls - expected) - prior * b)
    return b[1:], np.sqrt(np.diag(np.linalg.inv(hessian)))[1:]


def effects(outcomes: list[Outcome]) -> list[Effect]:
    """Return what each factor does, the clearest effect first."""
    b, error = fit(outcomes)
    found = []
    for k in np.argsort(-np.abs(b) / error).tolist():
        at_low, at_high = (
            [outcome for outcome in outcomes if (outcome.levels[k] > 0) is is_high]
            for is_high in (False, True)
        )
        ratio, spread = 2.0 * float(b[k]), 2.0 * 1.96 * float(error[k])
        found.append(
            Effect(
                NAMES[k],
                (_FACTORS[k].low, _FACTORS[k].high),
                math.exp(ratio),
                (math.exp(ratio - spread), math.exp(ratio + spread)),
                _counted(at_low),
                _counted(at_high),
            )
        )
    return found


def _counted(outcomes: list[Outcome]) -> tuple[int, int]:
    """Return the falls and the punches."""
    return sum(outcome.fell for outcome in outcomes), sum(outcome.punches for outcome in outcomes)


def _print(found: list[Effect], outcomes: list[Outcome]) -> None:
    falls, punches = _counted(outcomes)
    print(f"{len(outcomes)} short tours, {punches} punches, {falls} falls; falls per punch:\n")
    print(f"{'factor':32} {'levels':>13} {'high/low':>9} {'95 %':>13} {'low':>9} {'high':>9}")
    for effect in found:
        levels = "×{:g}, ×{:g}".format(*effect.levels)
        interval = "{:.2f} to {:.2f}".format(*effect.interval)
        low, high = ("{}/{}".format(*counted) for counted in (effect.low, effect.high))
        print(
            f"{effect.name:32} {levels:>13} {effect.ratio:9.2f} {interval:>13} {low:>9} {high:>9}"
        )


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--robot", default="g1_tour", help="default g1_tour")
    parser.add_argument("--tours", type=int, default=900, help="short tours, default 900")
    parser.add_argument("--friction", type=float, default=1.0, help="of the ground, default 1")
    parser.add_argument("--json", type=Path, metavar="FILE")
    options = parser.parse_args(argv)
    if options.tours < 1:
        parser.error(f"--tours {options.tours}: at least one")
    start = time.perf_counter()
    job = functools.partial(run, options.robot, options.friction)
    seeds = range(_FIRST_SEED, _FIRST_SEED + options.tours)
    with ProcessPoolExecutor() as pool:
        outcomes = [outcome for outcome in pool.map(job, seeds) if outcome.punches > 0]
    if not any(outcome.fell for outcome in outcomes):
        print(f"no fall in {len(outcomes)} short tours: nothing to tell the factors by")
        return 0
    found = effects(outcomes)
    _print(found, outcomes)
    print(f"\n{time.perf_counter() - start:.0f} s")
    if options.json:
        options.json.write_text(
            json.dumps([dataclasses.asdict(effect) for effect in found], indent=1) + "\n"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
