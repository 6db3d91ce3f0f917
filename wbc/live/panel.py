"""What the page offers: knobs, motions and pushes. The loop makes it, the server checks by it."""

from __future__ import annotations

import dataclasses
import json
import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from wbc.errors import MotionError, did_you_mean, short_repr
from wbc.live.errors import BadRequest
from wbc.live.words import checked_number
from wbc.motions import Motion
from wbc.motions.engine.parsing import create_motion, describe_motion

LONGEST = 1000  # characters of a message


class Kind(IntEnum):
    """What is wanted of the loop."""

    KNOB = 0  #: index, value
    PUSH = 1  #: forward, left; N·s
    MOTION = 2  #: slot on the shelf, size
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
        motion: that is wanted; the loop gets it planned and packed.
    """

    kind: Kind
    first: float = 0.0
    second: float = 0.0
    motion: Motion | None = None


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
            "motions": [describe_motion(motion) for motion in self.motions],
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
                return Request(Kind.KNOB, i, checked_number(name, value, knob.low, knob.high))
        if name == "push":
            return self._push(value)
        if name == "motion":
            return self._motion(value)
        if name == "pause":
            if not isinstance(value, bool):
                raise BadRequest(f"pause is {short_repr(value)}; it is true or false")
            return Request(Kind.PAUSE, float(value))
        if name in ("stand", "reset"):
            return Request(Kind[name.upper()])
        names = [knob.name for knob in self.knobs]
        names += ["push", "motion", "pause", "stand", "reset"]
        raise BadRequest(f"no control {short_repr(name)}{did_you_mean(name, names)}")

    def _push(self, value: Any) -> Request:
        if not (isinstance(value, list) and len(value) == 2):
            raise BadRequest(f"push is {short_repr(value)}; it is [forward, left] in N·s")
        most = self.max_impulse
        forward, left = (checked_number("push", part, -most, most) for part in value)
        if math.hypot(forward, left) > 1.0001 * most:
            raise BadRequest(f"push: {math.hypot(forward, left):.4g} N·s; at most {most:g} N·s")
        return Request(Kind.PUSH, forward, left)

    def _motion(self, value: Any) -> Request:
        name, parameters = value, {}
        if isinstance(value, dict) and value.keys() == {"name", "parameters"}:
            name, parameters = value["name"], value["parameters"]
        for motion in self.motions:
            if motion.name == name:
                try:
                    return Request(Kind.MOTION, motion=create_motion(motion, parameters))
                except MotionError as error:
                    raise BadRequest(str(error)) from error
        names = [motion.name for motion in self.motions]
        near = did_you_mean(name, names) if isinstance(name, str) else ""
        raise BadRequest(f"no motion {short_repr(name)}{near}")


def _opened(message: str | bytes) -> tuple[str, Any]:
    if not isinstance(message, str):
        raise BadRequest("a message is text, in JSON")
    if len(message) > LONGEST:
        raise BadRequest(f"a message of {len(message)} characters; at most {LONGEST}")
    try:
        said = json.loads(message)
    except (ValueError, RecursionError):
        raise BadRequest(f"{short_repr(message)} is not JSON") from None
    if not isinstance(said, dict) or not isinstance(said.get("control"), str):
        raise BadRequest(f'{short_repr(said)}: a message is {{"control": NAME, "value": …}}')
    return said["control"], said.get("value")
