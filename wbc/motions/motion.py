"""The base of all motions: parameters, and a script that is played tick by tick."""

from __future__ import annotations

import dataclasses
import functools
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar
from weakref import WeakKeyDictionary

from wbc.errors import MotionError
from wbc.robot import Robot

if TYPE_CHECKING:
    from wbc.motions.body import Body

M = TypeVar("M", bound="Motion")
P = TypeVar("P")

#: What `Motion.play` is: each `yield` is one tick.
Script = Generator[None, None, None]


@dataclass(frozen=True)
class Motion(ABC):
    """Something to do, from standing to standing.

    A motion is a frozen dataclass: its fields are its parameters, and the command line's
    options. `play` is a generator that gives orders to the body; each `yield` lets one tick
    pass, and `yield from body.wait(…)`, `body.until(…)`, `body.shift_weight(…)` and the like
    pass several. Being a generator, it can be interrupted at any `yield`; the performer then
    brings the body home. It should leave the body at home when it ends; what it forgets is
    brought home for it.

    Attributes:
        name: one word, as on the command line.
        summary: one line.
    """

    name: ClassVar[str]
    summary: ClassVar[str]

    def check(self, robot: Robot) -> None:  # noqa: B027 - most have nothing to check
        """Refuse what this robot cannot do, before it starts.

        Raises:
            MotionError: with the bound, and what sets it.
        """

    @abstractmethod
    def play(self, body: Body) -> Script:
        """The script.

        Raises:
            MotionError: it gives up; the performer notes why and brings the body home.
        """

    @classmethod
    def shown(cls) -> Motion:
        """As it is played in the show: by default with its default parameters."""
        return cls()

    @classmethod
    def parameters(cls) -> tuple[Parameter, ...]:
        """What may be chosen, in order."""
        found = []
        for field in dataclasses.fields(cls):
            default = field.default
            if default is dataclasses.MISSING:
                assert field.default_factory is not dataclasses.MISSING
                default = field.default_factory()
            found.append(
                Parameter(
                    field.name,
                    default,
                    field.metadata.get("about", ""),
                    tuple(field.metadata.get("choices", ())),
                    tuple(field.metadata.get("names", ())),
                )
            )
        return tuple(found)


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of a motion.

    Attributes:
        name: of the field.
        default: its type is the parameter's.
        about: what it is, with its unit.
        choices: the values that it may have; any when empty.
        names: of the components of a vector; empty for anything else.
    """

    name: str
    default: Any
    about: str
    choices: tuple[str, ...]
    names: tuple[str, ...]


def parameter(
    default: Any, about: str, *, choices: Sequence[str] = (), names: Sequence[str] = ()
) -> Any:
    """A field of a motion that is a parameter, with its unit said in `about`.

    Args:
        default: its type is the parameter's.
        about: what it is, with its unit.
        choices: for a text, the values that it may have.
        names: for a vector, one name per component.
    """
    metadata = {"about": about, "choices": tuple(choices), "names": tuple(names)}
    return dataclasses.field(default=default, metadata=metadata)


def once_per_robot(plan: Callable[[M, Robot], P]) -> Callable[[M, Robot], P]:
    """A method of a motion that plans for a robot: computed once, in `check`, before it starts.

    `play` runs inside the control loop, where there is no time to plan.
    """
    key = f"_{plan.__name__}_per_robot"

    @functools.wraps(plan)
    def remembered(motion: M, robot: Robot) -> P:
        found: WeakKeyDictionary[Robot, P] = motion.__dict__.setdefault(key, WeakKeyDictionary())
        if robot not in found:
            found[robot] = plan(motion, robot)
        return found[robot]

    return remembered


def positive(motion: Motion, *names: str) -> None:
    """Refuse parameters that are not positive and finite.

    Raises:
        MotionError: names the parameter and its value.
    """
    for name in names:
        value = getattr(motion, name)
        if not 0.0 < value < float("inf"):
            raise MotionError(f"{motion.name}: {name} = {value} must be positive and finite")
