"""Motions from text and from JSON: parsing and checking their parameters."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from typing import Any

from wbc.errors import MotionError, did_you_mean, short_repr
from wbc.motions.engine.motion import Motion, MotionParameter

# Bounds of a number: seconds, percent, degrees, N·s/kg. A script may divide by it in the loop,
# where nobody checks for overflows, so what is nearer to zero counts as a typing error.
_MIN, _MAX = 1e-6, 1e4
_MAX_INTEGER = 100  # each of them may be planned
_MAX_LENGTH = 300  # characters


def describe_motion(motion: type[Motion]) -> dict[str, Any]:
    """Return name, summary and parameters of a motion as plain data, for JSON."""
    parameters = [
        {
            "name": p.name,
            "kind": _kind(p),
            "default": p.default,
            "about": p.description,
            "choices": p.choices,
            "names": p.names,
            "suffixes": p.suffixes,
        }
        for p in motion.parameters()
    ]
    return {"name": motion.name, "summary": motion.summary, "parameters": parameters}


def create_motion(motion: type[Motion], values: Any) -> Motion:
    """Return a motion with these parameters, the others at their defaults.

    Args:
        motion: type of the motion.
        values: name -> value, as decoded from JSON.

    Raises:
        MotionError: there is no such parameter, or it cannot have that value.
    """
    known = {p.name: p for p in motion.parameters()}
    if not isinstance(values, dict):
        raise MotionError(
            f"parameters of {motion.name} are {short_repr(values)}; they must be an object"
        )
    for name in values:
        if name not in known:
            raise MotionError(
                f"{motion.name} has no parameter {short_repr(name)}{did_you_mean(name, known)}"
            )
    return motion(**{name: _value(motion, known[name], value) for name, value in values.items()})


def parse_motion(text: str, motions: Sequence[type[Motion]]) -> Motion:
    """Return the motion that a line of text describes.

    Example:
        >>> parse_motion("squat depth=15 times=2", MOTIONS)
        >>> parse_motion("reach left=0.3,0.2,1", MOTIONS)

    Args:
        text: name, then parameter=value …; quote a value that has spaces.
        motions: the types to choose from.

    Raises:
        MotionError: the text does not describe one of them.
    """
    try:
        name, *words = shlex.split(text) or [""]
    except ValueError as error:
        raise MotionError(f"{short_repr(text)} cannot be read: {error}") from None
    kinds = {motion.name: motion for motion in motions}
    if name not in kinds:
        raise MotionError(f"no motion {short_repr(name)}{did_you_mean(name, kinds)}")
    known = {p.name: p for p in kinds[name].parameters()}
    values = {}
    for word in words:
        key, equals, value = word.partition("=")
        if not equals:
            raise MotionError(f"{name}: {short_repr(word)} is not of the form parameter=value")
        if key in values:
            raise MotionError(f"{name}: {key} is given twice")
        values[key] = _read(known[key], value) if key in known else value
    return create_motion(kinds[name], values)


def _read(parameter: MotionParameter, text: str) -> Any:
    """Return the value that JSON would have; a text that cannot be parsed is refused later."""
    kind = _kind(parameter)
    if kind == "switch":
        return {"true": True, "false": False}.get(text, text)
    try:
        if kind == "vector":
            return [float(part) for part in text.split(",")]
        return float(text) if kind in ("number", "whole") else text
    except ValueError:
        return text


def _kind(parameter: MotionParameter) -> str:
    if parameter.choices:
        return "choice"
    if parameter.names:
        return "vector"
    if parameter.suffixes:
        return "file"
    kinds = ((bool, "switch"), (int, "whole"), (float, "number"))
    return next((name for kind, name in kinds if isinstance(parameter.default, kind)), "text")


def _value(motion: type[Motion], parameter: MotionParameter, value: Any) -> Any:
    name, kind = f"{motion.name}: {parameter.name}", _kind(parameter)
    if kind == "choice":
        if value not in parameter.choices:
            raise MotionError(
                f"{name} is {short_repr(value)}; it must be {' or '.join(parameter.choices)}"
            )
        return value
    if kind == "vector":
        if value is None and parameter.default is None:
            return None
        size = len(parameter.names)
        if not (isinstance(value, list) and len(value) == size and None not in value):
            raise MotionError(f"{name} is {short_repr(value)}; it must be {size} numbers")
        return tuple(_number(name, x, _MAX) for x in value)
    if kind == "switch":
        if not isinstance(value, bool):
            raise MotionError(f"{name} is {short_repr(value)}; it must be true or false")
        return value
    if kind == "whole":
        number = _number(name, value, _MAX_INTEGER)
        if number != int(number):
            raise MotionError(f"{name} is {short_repr(value)}; it must be an integer")
        return int(number)
    if kind == "number":
        number = _number(name, value, _MAX)
        if 0.0 < abs(number) < _MIN:
            raise MotionError(f"{name} = {number:g} is too small: 0, or {_MIN:g} and more")
        return number
    if not (isinstance(value, str) and len(value) <= _MAX_LENGTH and value.isprintable()):
        raise MotionError(
            f"{name} is {short_repr(value)}; it must be a text of {_MAX_LENGTH} characters or fewer"
        )
    return value


def _number(name: str, value: Any, bound: float) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise MotionError(f"{name} is {short_repr(value)}; it must be a number")
    # Compared as it is: a whole number may be too large for a float.
    if not -bound <= value <= bound:
        raise MotionError(f"{name} = {short_repr(value)} is out of range: {-bound:g} to {bound:g}")
    return float(value)
