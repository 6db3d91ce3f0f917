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


class FrameNotFound(WbcError, KeyError):
    """The model has no frame of that name."""

    def __init__(self, name: str, names: Iterable[str], user: str = "") -> None:
        who = f"{user}: " if user else ""
        super().__init__(f"{who}the model has no frame '{name}'{did_you_mean(name, names)}")

    def __str__(self) -> str:  # KeyError would print the repr of the message
        return str(self.args[0])


class JointNotFound(WbcError, KeyError):
    """The model has no actuated joint of that name."""

    def __init__(self, name: str, names: Iterable[str], user: str = "") -> None:
        who = f"{user}: " if user else ""
        super().__init__(f"{who}the model has no joint '{name}'{did_you_mean(name, names)}")

    def __str__(self) -> str:
        return str(self.args[0])


class TaskError(WbcError, ValueError):
    """A task was given a negative weight, a target of the wrong shape or the like."""


class ContactError(WbcError, ValueError):
    """A contact or a foot wrench has a wrong shape, name or value."""


class LimitError(WbcError, ValueError):
    """A limit has a wrong size or an empty range."""


class SolverNotFound(WbcError):
    """The QP solver is unknown or not installed."""


class GaitError(WbcError, ValueError):
    """A gait parameter or a velocity command makes no sense."""


class MotionError(WbcError, ValueError):
    """A motion was given what it cannot do, or is used at the wrong moment."""


class MeasurementError(WbcError, ValueError):
    """A measurement has a wrong size or a value that is not finite."""


class PlantError(WbcError):
    """The simulated plant cannot be built or stepped as asked."""


class PhysicsDiverged(PlantError):
    """The simulated physics has left the range of finite, plausible states."""


class MissingExtra(WbcError, ImportError):
    """An optional dependency is not installed; the text names the pip command."""

    def __init__(self, module: str, extra: str) -> None:
        super().__init__(
            f"'{module}' is not installed: it comes with the extra '{extra}'; "
            f"run  pip install 'wbc[{extra}]'"
        )


def did_you_mean(name: str, names: Iterable[str], most: int = 3) -> str:
    """`"; did you mean 'a' or 'b'?"`, or a short list of what there is."""
    known = list(names)
    near = difflib.get_close_matches(name, known, n=most, cutoff=0.6)
    # A fragment of a name ("sole") is a better hint than its spelling distance.
    near += [k for k in known if name.lower() in k.lower() and k not in near][: most - len(near)]
    if near:
        return "; did you mean " + " or ".join(f"'{n}'" for n in near) + "?"
    if not known:
        return ""
    listed = ", ".join(known[:12]) + (", …" if len(known) > 12 else "")
    return f"; there are: {listed}"


def short_repr(value: Any) -> str:
    """The `repr` of any value in at most 60 characters, for messages."""
    if value is None:
        return "missing"
    try:
        text = repr(value)
    except ValueError:  # a whole number of thousands of digits
        text = "a number of very many digits"
    return text if len(text) <= 60 else text[:57] + "…"
