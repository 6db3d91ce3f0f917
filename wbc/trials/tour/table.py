"""The result of many tours in a table, beside the published ones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from wbc.trials.tour.run import TourResult


@dataclass(frozen=True, slots=True)
class PublishedResult:
    """The published result of a policy in the public benchmark, in MuJoCo.

    Attributes:
        name: name of the policy there.
        completed: share of the runs that ended on the feet.
        survived: mean time until the end or the fall, s.
        position_error: m.
        yaw_error: rad.
    """

    name: str
    completed: float
    survived: float
    position_error: float
    yaw_error: float


def _published(name: str, survived: float, percent: int, cm: int, degrees: int) -> PublishedResult:
    return PublishedResult(name, 0.01 * percent, survived, 0.01 * cm, math.radians(degrees))


#: The best entries of each policy family in https://github.com/rhoyn/teleop-walking-benchmark at
#: commit 0b2ea7a, column "mujoco", and rl_lab, which can be run here: `wbc.trials.policy`.
PUBLISHED = (
    _published("gr00t_wbc", 85.2, 80, 17, 8),
    _published("decoupled_wbc", 83.9, 75, 10, 7),
    _published("homie", 78.2, 55, 17, 32),
    _published("amo", 75.9, 54, 24, 17),
    _published("grove", 74.9, 49, 21, 7),
    _published("wbc_agile", 71.2, 34, 23, 8),
    _published("sonic", 69.2, 36, 29, 9),
    _published("run_residual", 50.7, 6, 581, 14),
    _published("mimic_lite", 47.9, 9, 82, 12),
    _published("asap", 46.3, 7, 141, 32),
    _published("robomimic", 44.7, 6, 195, 14),
    _published("falcon", 37.7, 2, 42, 14),
    _published("openwbt", 26.5, 0, 81, 48),
    _published("rl_lab", 25.5, 0, 57, 74),
    _published("wty_cpp", 23.0, 0, 31, 24),
)


def summary(name: str, results: Sequence[TourResult]) -> PublishedResult:
    """Return the result of many runs in the form of the published ones.

    Args:
        name: name of the controller.
        results: at least one.
    """
    count = len(results)
    return PublishedResult(
        name,
        sum(result.completed for result in results) / count,
        sum(result.survived for result in results) / count,
        sum(result.position_error for result in results) / count,
        sum(result.yaw_error for result in results) / count,
    )
