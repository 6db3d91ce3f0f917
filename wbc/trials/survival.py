"""Survival rates of a grid, and the largest disturbance that is survived."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from wbc.trials.result import TrialResult
from wbc.trials.trial import Velocity

REQUIRED_SHARE = 0.95  # of the trials that must survive for a size to count as survived


@dataclass(frozen=True, slots=True)
class Case:
    """What a row of a survival table stands for.

    Attributes:
        robot: name or path.
        controller: name of the controller.
        velocity: commanded: forward, left (m/s), turn (rad/s).
        condition: name of the condition.
    """

    robot: str
    controller: str
    velocity: Velocity
    condition: str

    @classmethod
    def of(cls, row: TrialResult) -> Case:
        """Return the case of a result."""
        velocity = (row.velocity_forward, row.velocity_left, row.velocity_turn)
        return cls(row.robot, row.controller, velocity, row.condition)

    @property
    def motion(self) -> str:
        """The commanded velocity in words."""
        forward, left, turn = self.velocity
        if not any(self.velocity):
            return "standing"
        parts = [f"{forward:g} m/s"] if forward or not (left or turn) else []
        parts += [f"{left:+g} m/s left"] if left else []
        parts += [f"{turn:+g} rad/s"] if turn else []
        return ", ".join(parts)


@dataclass(frozen=True, slots=True)
class SurvivalRate:
    """How many trials were survived of those with one size of the disturbance.

    Attributes:
        size: in the unit of the disturbance.
        survived: number of trials that were survived.
        trials: number of trials.
    """

    size: float
    survived: int
    trials: int

    @property
    def share(self) -> float:
        """Share of the trials that were survived."""
        return self.survived / self.trials

    def interval(self, confidence: float = 0.95) -> tuple[float, float]:
        """Return the confidence interval of the share (Wilson, JASA 22, 1927)."""
        from scipy.stats import binomtest

        interval = binomtest(self.survived, self.trials).proportion_ci(confidence, "wilson")
        return float(interval.low), float(interval.high)


@dataclass(frozen=True, slots=True)
class Survival:
    """The survival rates of a case in one direction.

    Attributes:
        case: the case.
        direction: degrees counter-clockwise from the robot's heading.
        rates: by increasing size.
    """

    case: Case
    direction: float
    rates: tuple[SurvivalRate, ...]

    def largest_survived(self, share: float = REQUIRED_SHARE) -> float:
        """Return the largest size that is survived in that share of the trials.

        All smaller sizes have to be survived as well: survival is not monotone. 0 if none is.
        """
        largest = 0.0
        for rate in self.rates:
            if rate.share < share:
                break
            largest = rate.size
        return largest


def survival_rates(trials: Iterable[TrialResult]) -> tuple[Survival, ...]:
    """Return the survival of each case and direction, in the order of the trials."""
    counts: dict[tuple[Case, float], dict[float, list[int]]] = {}
    for row in trials:
        if row.direction_deg is None or row.size is None:
            continue  # an undisturbed run
        sizes = counts.setdefault((Case.of(row), row.direction_deg), {})
        count = sizes.setdefault(row.size, [0, 0])
        count[0] += row.survived
        count[1] += 1
    return tuple(
        Survival(case, direction, tuple(SurvivalRate(s, *sizes[s]) for s in sorted(sizes)))
        for (case, direction), sizes in counts.items()
    )


def differing_fields(cases: Sequence[Case]) -> tuple[str, ...]:
    """Return the fields of `Case` that tell cases apart, and always robot and velocity."""
    return tuple(
        name
        for name in ("robot", "velocity", "controller", "condition")
        if name in ("robot", "velocity") or len({getattr(case, name) for case in cases}) > 1
    )
