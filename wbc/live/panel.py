"""What the page offers: knobs, motions and pushes. The loop makes it, the server checks by it."""

from __future__ import annotations

import dataclasses
import json
import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from wbc.errors import did_you_mean
from wbc.live.errors import BadRequest
from wbc.motions import Motion

LONGEST = 1000  # characters of a message


class Kind(IntEnum):
    """What is wanted of the loop."""

    KNOB = 0  #: index, value
    PUSH = 1  #: forward, left; N·s
    MOTION = 2  #: index
    STAND = 3
    PAUSE = 4  #: 1 to pause, 0 to go on
    RESET = 5


@dataclass(frozen=True, slots=True)
class Knob:
    """A number that may be set.

    Attributes:
        name: unique, e.g. "gait.swing_height".
        group: "velocity", "time", "gait", or a task's name.
        label: for human eyes.
        unit: of the value.
        low: smallest value.
        high: largest value.
        value: where it starts.
        logarithmic: its slider moves by ratios.
    """

    name: str
    group: str
    label: str
    unit: str
    low: float
    high: float
    value: float
    logarithmic: bool = False


@dataclass(frozen=True, slots=True)
class Request:
    """A message that makes sense.

    Attributes:
        kind: what is wanted.
        first: see `Kind`.
        second: see `Kind`.
    """

    kind: Kind
    first: float = 0.0
    second: float = 0.0


@dataclass(frozen=True)
class Panel:
    """Everything that may be wanted.

    Attributes:
        knobs: in the page's order.
        motions: likewise.
        max_impulse: largest push, N·s.
    """

    knobs: tuple[Knob, ...]
    motions: tuple[type[Motion], ...]
    max_impulse: float

    def describe(self) -> dict[str, Any]:
        """For the page."""
        return {
            "knobs": [dataclasses.asdict(knob) for knob in self.knobs],
            "motions": [{"name": m.name, "summary": m.summary} for m in self.motions],
            "max_impulse": self.max_impulse,
        }

    def request(self, message: str | bytes) -> Request:
        """What a page's message wants: `{"control": NAME, "value": …}`.

        Raises:
            BadRequest: it makes no sense; the text says why.
        """
        name, value = _opened(message)
        for i, knob in enumerate(self.knobs):
            if knob.name == name:
                return Request(Kind.KNOB, i, _number(name, value, knob.low, knob.high))
        if name == "push":
            return self._push(value)
        if name == "motion":
            return self._motion(value)
        if name == "pause":
            if not isinstance(value, bool):
                raise BadRequest(f"pause is {_shown(value)}; it is true or false")
            return Request(Kind.PAUSE, float(value))
        if name in ("stand", "reset"):
            return Request(Kind[name.upper()])
        names = [knob.name for knob in self.knobs]
        names += ["push", "motion", "pause", "stand", "reset"]
        raise BadRequest(f"no control {_shown(name)}{did_you_mean(name, names)}")

    def _push(self, value: Any) -> Request:
        if not (isinstance(value, list) and len(value) == 2):
            raise BadRequest(f"push is {_shown(value)}; it is [forward, left] in N·s")
        most = self.max_impulse
        forward, left = (_number("push", part, -most, most) for part in value)
        if math.hypot(forward, left) > 1.0001 * most:
            raise BadRequest(f"push: {math.hypot(forward, left):.4g} N·s; at most {most:g} N·s")
        return Request(Kind.PUSH, forward, left)

    def _motion(self, value: Any) -> Request:
        names = [motion.name for motion in self.motions]
        if value not in names:
            near = did_you_mean(value, names) if isinstance(value, str) else ""
            raise BadRequest(f"no motion {_shown(value)}{near}")
        return Request(Kind.MOTION, names.index(value))


def _opened(message: str | bytes) -> tuple[str, Any]:
    if not isinstance(message, str):
        raise BadRequest("a message is text, in JSON")
    if len(message) > LONGEST:
        raise BadRequest(f"a message of {len(message)} characters; at most {LONGEST}")
    try:
        said = json.loads(message)
    except (ValueError, RecursionError):
        raise BadRequest(f"{_shown(message)} is not JSON") from None
    if not isinstance(said, dict) or not isinstance(said.get("control"), str):
        raise BadRequest(f'{_shown(said)}: a message is {{"control": NAME, "value": …}}')
    return said["control"], said.get("value")


def _number(name: str, value: Any, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise BadRequest(f"{name} is {_shown(value)}; it is a number")
    # Compared as it is: a whole number may be too large for a float.
    if not low <= value <= high:
        raise BadRequest(f"{name} = {_shown(value)} is out of range: {low:g} to {high:g}")
    return float(value)


def _shown(value: Any) -> str:
    try:
        text = repr(value)
    except ValueError:  # a whole number of thousands of digits
        text = "a number of very many digits"
    return text if len(text) <= 60 else text[:57] + "…"
