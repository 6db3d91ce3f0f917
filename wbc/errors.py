"""The library's exceptions: each names the thing, the value and the cure.

Everything raised on purpose derives from `WbcError`, so one `except` catches
the library and nothing else.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any


class WbcError(Exception):
    """Base of every exception that this library raises on purpose."""


class RobotNotFound(WbcError):
    """No robot of that name, and no file at that path."""


class RobotDescriptionError(WbcError):
    """A URDF, SRDF or robot data file cannot be read or makes no usable model."""


class StateError(WbcError, ValueError):
    """A configuration or velocity has a wrong size, a NaN or a non-unit quaternion."""


class _NameNotFound(WbcError, KeyError):
    """The model has nothing of that name; the text lists similar names.

    Args:
        name: name that was looked up.
        names: existing names.
        caller: who looked it up, for the message.
    """

    _kind = "name"

    def __init__(self, name: str, names: Iterable[str], caller: str = "") -> None:
        where = f"{caller}: " if caller else ""
        text = f"{where}the model has no {self._kind} '{name}'{did_you_mean(name, names)}"
        super().__init__(text)

    def __str__(self) -> str:  # KeyError would print the repr of the message
        return str(self.args[0])

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickled, (type(self), str(self))


class FrameNotFound(_NameNotFound):
    """The model has no frame of that name."""

    _kind = "frame"


class JointNotFound(_NameNotFound):
    """The model has no actuated joint of that name."""

    _kind = "joint"


class TaskError(WbcError, ValueError):
    """A task has a negative weight, a target of the wrong shape or another invalid value."""


class ContactError(WbcError, ValueError):
    """A contact or a foot wrench has a wrong shape, name or value."""


class LimitError(WbcError, ValueError):
    """A limit has a wrong size or an empty range."""


class SolverNotFound(WbcError):
    """The QP solver is unknown or not installed."""


class PlannerNotFound(WbcError):
    """There is no planner of that name, or the object is none."""


class GaitError(WbcError, ValueError):
    """A gait parameter, a footstep or a velocity command is invalid."""


class MotionError(WbcError, ValueError):
    """A motion has an invalid parameter, cannot be performed, or is requested at a wrong time."""


class MeasurementError(WbcError, ValueError):
    """A measurement has a wrong size or a value that is not finite."""


class ServoError(WbcError, ValueError):
    """Servo gains or properties of servos are invalid."""


class PlantError(WbcError):
    """The simulated plant cannot be built or stepped with these arguments."""


class PhysicsDiverged(PlantError):
    """The simulated physics has left the range of finite, plausible states."""


class MissingExtra(WbcError, ImportError):
    """An optional dependency is not installed; the text names the pip command.

    Args:
        module: the missing package.
        extra: the extra that brings it.
        others: further extras that bring it.
    """

    def __init__(self, module: str, extra: str, *others: str) -> None:
        extras = " and ".join(f"'{name}'" for name in (extra, *others))
        commands = " or  ".join(f"pip install 'wbc[{name}]'" for name in (extra, *others))
        which = f"the extras {extras}" if others else f"the extra {extras}"
        super().__init__(f"'{module}' is not installed: it comes with {which}; run  {commands}")

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickled, (type(self), str(self))


def _unpickled(kind: type[WbcError], text: str) -> WbcError:
    """An error with its text, built without the arguments that the text was made of."""
    error = kind.__new__(kind)
    error.args = (text,)
    if isinstance(error, ImportError):
        error.msg = text
    return error


def did_you_mean(name: str, names: Iterable[str], most: int = 3) -> str:
    """Return `"; did you mean 'a' or 'b'?"`, or a list of the first names if none is similar."""
    known = list(names)
    similar = difflib.get_close_matches(name, known, n=most, cutoff=0.6)
    # Names that contain the word are better hints than names of similar spelling.
    containing = [k for k in known if name.lower() in k.lower() and k not in similar]
    similar += containing[: most - len(similar)]
    if similar:
        return "; did you mean " + " or ".join(f"'{n}'" for n in similar) + "?"
    if not known:
        return ""
    listed = ", ".join(known[:12]) + (", …" if len(known) > 12 else "")
    return f"; there are: {listed}"


def short_repr(value: Any) -> str:
    """Return the `repr` of any value in at most 60 characters, for messages."""
    if value is None:
        return "missing"
    try:
        text = repr(value)
    except ValueError:  # a whole number of thousands of digits
        text = "a number of very many digits"
    return text if len(text) <= 60 else text[:57] + "…"
