"""The base of all motions: parameters, and a script that is played tick by tick."""

from __future__ import annotations

import dataclasses
import functools
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeVar
from weakref import WeakKeyDictionary

from wbc.errors import MotionError, did_you_mean
from wbc.motions.engine.clock import Script
from wbc.motions.engine.context import MotionContext
from wbc.robot import Robot

M = TypeVar("M", bound="Motion")
P = TypeVar("P")


@dataclass(frozen=True)
class Motion(ABC):
    """A motion of the whole robot, from standing to standing.

    A motion is a frozen dataclass: its fields are its parameters, and the command line's
    options. `play` is a generator that sets the references of a context; each `yield` lets one
    tick pass, and `yield from context.wait(…)`, `context.until(…)`, `context.feet.lift(…)` and
    the like let several pass. Because it is a generator, it can be interrupted at any `yield`;
    the player then returns the robot to standing. At its end every reference should be at its
    home value; the player moves back those that are not.

    Attributes:
        name: one word, as on the command line.
        summary: one line.
    """

    name: ClassVar[str]
    summary: ClassVar[str]

    @property
    def while_walking(self) -> bool:
        """Whether the robot may walk meanwhile, because the motion leaves legs and CoM alone.

        Such a motion neither starts nor ends walking; others begin when the robot stands.
        """
        return False

    def check(self, robot: Robot) -> None:  # noqa: B027 - most motions have nothing to check
        """Refuse what this robot cannot do, before it starts; plan what is `once_per_robot`.

        Raises:
            MotionError: with the bound, and what sets it.
        """

    def prepare(self, robot: Robot) -> None:
        """Check, and plan, once per robot. This may take a second: never call it in a running loop.

        A motion that has been prepared starts without delay: prepare it before the loop, or in
        another process, and transfer it with `wbc.motions.pack`.

        Raises:
            MotionError: the robot cannot do it.
        """
        _checked(self, robot)

    @abstractmethod
    def play(self, context: MotionContext) -> Script:
        """Return the script.

        Raises:
            MotionError: the motion aborts; the player records why, and the robot stands again.
        """

    @classmethod
    def for_demo(cls) -> Motion:
        """Return the motion as `Demo` plays it: with default parameters unless overridden."""
        return cls()

    @classmethod
    def parameters(cls) -> tuple[MotionParameter, ...]:
        """Return the parameters of this type of motion, in order."""
        found = []
        for field in dataclasses.fields(cls):
            default = field.default
            if default is dataclasses.MISSING:
                assert field.default_factory is not dataclasses.MISSING
                default = field.default_factory()
            found.append(
                MotionParameter(
                    field.name,
                    default,
                    field.metadata.get("description", ""),
                    tuple(field.metadata.get("choices", ())),
                    tuple(field.metadata.get("names", ())),
                    tuple(field.metadata.get("suffixes", ())),
                )
            )
        return tuple(found)


@dataclass(frozen=True, slots=True)
class MotionParameter:
    """A parameter of a motion.

    Attributes:
        name: name of the field.
        default: default value; its type is the parameter's.
        description: meaning and unit.
        choices: the values that it may have; any when empty.
        names: names of the components of a vector; empty for anything else.
        suffixes: of the files that it may name; empty unless it is the path of a file.
    """

    name: str
    default: Any
    description: str
    choices: tuple[str, ...]
    names: tuple[str, ...]
    suffixes: tuple[str, ...] = ()


def parameter(
    default: Any,
    description: str,
    *,
    choices: Sequence[str] = (),
    names: Sequence[str] = (),
    suffixes: Sequence[str] = (),
) -> Any:
    """Return a dataclass field that is a parameter of a motion.

    Args:
        default: default value; its type is the parameter's.
        description: meaning and unit.
        choices: for a text, the values that it may have.
        names: for a vector, one name per component.
        suffixes: for the path of a file, the suffixes that it may have, e.g. ".csv".
    """
    metadata = {
        "description": description,
        "choices": tuple(choices),
        "names": tuple(names),
        "suffixes": tuple(suffixes),
    }
    return dataclasses.field(default=default, metadata=metadata)


class _PerRobot(WeakKeyDictionary[Robot, P]):
    """Plans by robot; they are pickled along with the motion."""

    def __reduce__(self) -> tuple[type, tuple[dict[Robot, P]]]:
        return _PerRobot, (dict(self),)


def once_per_robot(plan: Callable[[M, Robot], P]) -> Callable[[M, Robot], P]:
    """Cache a planning method of a motion by robot; call it in `check`, before the loop.

    `play` runs inside the control loop, where there is no time to plan.
    """
    key = f"_{plan.__name__}_per_robot"

    @functools.wraps(plan)
    def cached(motion: M, robot: Robot) -> P:
        found: _PerRobot[P] = motion.__dict__.setdefault(key, _PerRobot())
        if robot not in found:
            found[robot] = plan(motion, robot)
        return found[robot]

    return cached


@once_per_robot
def _checked(motion: Motion, robot: Robot) -> None:
    _check_values(motion)
    motion.check(robot)


def _check_values(motion: Motion) -> None:
    """Check that texts are among their choices and that numbers are finite."""
    for parameter in motion.parameters():
        value = getattr(motion, parameter.name)
        if parameter.choices and value not in parameter.choices:
            near = did_you_mean(str(value), parameter.choices)
            raise MotionError(f"{motion.name}: no {parameter.name} '{value}'{near}")
        numbers = value if isinstance(value, tuple) else (value,)
        if not all(math.isfinite(x) for x in numbers if isinstance(x, float)):
            raise MotionError(f"{motion.name}: {parameter.name} = {value} must be finite")


def check_positive(motion: Motion, *names: str) -> None:
    """Refuse parameters that are not positive and finite.

    Raises:
        MotionError: names the parameter and its value.
    """
    for name in names:
        value = getattr(motion, name)
        if not 0.0 < value < float("inf"):
            raise MotionError(f"{motion.name}: {name} = {value} must be positive and finite")
