"""A grid of trials: robots × controllers × velocities × conditions × seeds × pushes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from wbc.errors import did_you_mean
from wbc.trials.condition import Condition
from wbc.trials.controllers import ControllerSpec
from wbc.trials.disturbance import DIRECTIONS, Disturbance, PushDisturbance, parse_direction
from wbc.trials.errors import TrialError
from wbc.trials.trial import Trial, UndisturbedRun, Velocity


@dataclass(frozen=True)
class RobotCases:
    """A robot, and the velocities at which it is disturbed.

    Attributes:
        robot: name of a robot, or path of a URDF or robot data file.
        velocities: forward (m/s), or forward, left (m/s) and turn (rad/s); 0 is standing.
        sizes: sizes of the disturbance in place of the grid's; or name of a direction -> sizes, in
            place of the grid's directions too.
        controllers: names of the controllers that it is run with; all of the grid's when left out.
    """

    robot: str
    velocities: tuple[float | Velocity, ...] = (0.0,)
    sizes: tuple[float, ...] | dict[str, tuple[float, ...]] | None = None
    controllers: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        if not self.velocities:
            raise TrialError(f"robot '{self.robot}' has no velocities")
        if self.controllers is not None and not self.controllers:
            raise TrialError(f"robot '{self.robot}' has no controllers")
        velocities = tuple(
            v if isinstance(v, tuple) else (float(v), 0.0, 0.0) for v in self.velocities
        )
        if not all(math.isfinite(x) for v in velocities for x in v):
            raise TrialError(f"robot '{self.robot}': velocities must be finite")
        object.__setattr__(self, "velocities", velocities)
        sizes = self.sizes
        if isinstance(sizes, dict):
            for direction in sizes:
                parse_direction(direction)
            by_direction = {name: _checked_sizes(given) for name, given in sizes.items()}
            object.__setattr__(self, "sizes", by_direction)
        elif sizes is not None:
            object.__setattr__(self, "sizes", _checked_sizes(sizes))


@dataclass(frozen=True)
class Grid:
    """A declared grid of trials; read from TOML by `read_grid`.

    Each robot is run at each of its velocities with each controller, condition and seed, and
    disturbed at each phase from each direction with each size.

    Attributes:
        robots: the robots and their velocities.
        sizes: sizes of the disturbance, in its unit.
        name: a title.
        controllers: the controllers under test.
        conditions: in what the plant differs from the nominal one.
        disturbance: kind of the disturbance.
        phases: number of times, equally spaced over a gait cycle.
        directions: names ("forward", "left", "back", "right") or degrees counter-clockwise from
            the robot's heading.
        seeds: seeds of sensor noise and terrain.
        duration: time simulated from the disturbance on, s.

    Raises:
        TrialError: an empty list, a repeated entry, an unknown controller or a number out of its
            range.
    """

    robots: tuple[RobotCases, ...]
    sizes: tuple[float, ...]
    name: str = "trials"
    controllers: tuple[ControllerSpec, ...] = (ControllerSpec(),)
    conditions: tuple[Condition, ...] = (Condition(),)
    disturbance: Disturbance = PushDisturbance()  # noqa: RUF009 - it is frozen
    phases: int = 6
    directions: tuple[str | float, ...] = tuple(DIRECTIONS)
    seeds: tuple[int, ...] = (0,)
    duration: float = 4.0

    def __post_init__(self) -> None:
        for name in ("robots", "sizes", "controllers", "conditions", "directions", "seeds"):
            if not getattr(self, name):
                raise TrialError(f"grid '{self.name}': {name} is empty")
        object.__setattr__(self, "sizes", _checked_sizes(self.sizes))
        entries: tuple[tuple[str, list[Any]], ...] = (
            ("controllers", [c.name for c in self.controllers]),
            ("conditions", [c.name for c in self.conditions]),
            ("robots", [f"{r.robot} at {v}" for r in self.robots for v in r.velocities]),
            ("seeds", list(self.seeds)),
            ("directions", [parse_direction(d) for d in self.directions]),
        )
        for what, names in entries:
            repeated = {name for name in names if names.count(name) > 1}
            if repeated:
                raise TrialError(
                    f"grid '{self.name}': {what} has {min(repeated)!r} more than once; give each "
                    "a name of its own"
                )
        known = [controller.name for controller in self.controllers]
        for cases in self.robots:
            for name in cases.controllers or ():
                if name not in known:
                    raise TrialError(
                        f"robot '{cases.robot}': the grid has no controller '{name}'"
                        f"{did_you_mean(name, known)}"
                    )
        if self.phases < 1:
            raise TrialError(f"phases = {self.phases} must be at least 1")
        if not all(seed >= 0 for seed in self.seeds):
            raise TrialError("seeds must be whole numbers of at least 0")
        if not (math.isfinite(self.duration) and self.duration > 0.0):
            raise TrialError(f"duration = {self.duration} s must be positive")

    def fractions(self) -> tuple[Fraction, ...]:
        """Return the phases as shares of a gait cycle."""
        return tuple(Fraction(k, self.phases) for k in range(self.phases))

    def runs(self) -> Iterator[UndisturbedRun]:
        """Return the undisturbed runs of the grid."""
        for cases, controller, condition, seed in itertools.product(
            self.robots, self.controllers, self.conditions, self.seeds
        ):
            if cases.controllers is not None and controller.name not in cases.controllers:
                continue
            for velocity in cases.velocities:
                assert isinstance(velocity, tuple)
                yield UndisturbedRun(cases.robot, controller, velocity, condition, seed)

    def trials(self, run: UndisturbedRun) -> Iterator[Trial]:
        """Return the trials that are forked from a run."""
        cases = next(
            cases
            for cases in self.robots
            if cases.robot == run.robot and run.velocity in cases.velocities
        )
        own = cases.sizes
        if not isinstance(own, dict):
            by_direction = dict.fromkeys(map(parse_direction, self.directions), own or self.sizes)
        else:
            by_direction = {parse_direction(name): sizes for name, sizes in own.items()}
        for phase, (degrees, sizes) in itertools.product(self.fractions(), by_direction.items()):
            for size in sizes:
                yield Trial(run, phase, self.disturbance, degrees, size, self.duration)


def _checked_sizes(sizes: tuple[float, ...]) -> tuple[float, ...]:
    """Return sizes as floats, so that 1 and 1.0 are the same trial."""
    if not all(math.isfinite(size) and size > 0.0 for size in sizes):
        raise TrialError(f"sizes = {list(sizes)} must be positive numbers")
    if len(set(sizes)) < len(sizes):
        raise TrialError(f"sizes = {list(sizes)} has a size more than once")
    return tuple(float(size) for size in sizes)
