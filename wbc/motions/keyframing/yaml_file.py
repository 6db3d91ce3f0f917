"""Keyframes in YAML, read as a tree of nodes that have line and column.

units: {angle: deg, length: m}    # of what follows; time is in s
keyframes:
  - time: 1.0
    joints: {left_elbow: 60}
    places: {left_hand: [0.35, 0.25, 1.1]}
"""

from __future__ import annotations

from typing import Any

from wbc.errors import MissingExtra, did_you_mean
from wbc.motions.keyframing.keyframe import (
    UNITS,
    FilePosition,
    FileValue,
    Keyframe,
    KeyframeError,
    number,
    scale,
)


def from_yaml(text: str, source: str) -> list[Keyframe]:
    """Return the keyframes of a YAML text.

    Raises:
        KeyframeError: with line and column.
        MissingExtra: PyYAML is not installed.
    """
    try:
        import yaml
    except ImportError:
        raise MissingExtra("yaml", "yaml") from None
    try:
        root = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = FilePosition(mark.line + 1, mark.column + 1) if mark else FilePosition(1, 1)
        raise KeyframeError(source, where, f"malformed YAML: {error.problem}") from None
    except yaml.reader.ReaderError as error:
        before = text[: error.position]
        where = FilePosition(before.count("\n") + 1, len(before) - before.rfind("\n"))
        wrong = f"character {ord(text[error.position]):#04x} is not allowed"
        raise KeyframeError(source, where, f"malformed YAML: {wrong}") from None
    return _Tree(source).keyframes(root)


class _Tree:
    """Converts YAML nodes to keyframes."""

    def __init__(self, source: str) -> None:
        self._source = source
        self._angle = self._length = 0.0

    def keyframes(self, root: Any) -> list[Keyframe]:
        table = self._table(root, "the file", ("units", "keyframes"))
        units = self._table(table.get("units"), "units", ("angle", "length"), at=root)
        self._angle, self._length = (self._unit(units.get(q), q) for q in ("angle", "length"))
        frames = table.get("keyframes")
        if frames is None or frames.id != "sequence" or not frames.value:
            raise self._error(frames or root, "'keyframes' must be a list, one entry per keyframe")
        return [self._keyframe(node) for node in frames.value]

    def _unit(self, node: Any, quantity: str) -> float:
        """Return the factor to SI units; 0 if it is not stated."""
        if node is None:
            return 0.0
        if node.id != "scalar":
            raise self._error(node, f"one of {', '.join(UNITS[quantity])} is expected here")
        return scale(str(node.value), (quantity,), _where(node), self._source)[1]

    def _keyframe(self, node: Any) -> Keyframe:
        table = self._table(node, "a keyframe", ("time", "joints", "places"))
        if "time" not in table:
            raise self._error(node, "a keyframe needs its time, in s")
        joints = {
            name: self._value(value, self._angle, "angle")
            for name, value in self._table(table.get("joints"), "joints", at=node).items()
        }
        places = {}
        for name, value in self._table(table.get("places"), "places", at=node).items():
            if value.id != "sequence" or len(value.value) != 3:
                raise self._error(value, f"'{name}' must be a place [x, y, z]")
            x, y, z = (self._value(v, self._length, "length") for v in value.value)
            places[name] = (x, y, z)
        return Keyframe(self._value(table["time"], 1.0, "time"), joints, places)

    def _table(
        self, node: Any, what: str, keys: tuple[str, ...] = (), at: Any = None
    ) -> dict[str, Any]:
        if node is None and at is not None:
            return {}
        if node is None or node.id != "mapping":
            raise self._error(node, f"{what} must be a table of names and values")
        table: dict[str, Any] = {}
        for key, value in node.value:
            if key.id != "scalar":
                raise self._error(key, f"{what} must be a table of names and values")
            if keys and key.value not in keys:
                raise self._error(key, f"unknown key '{key.value}'{did_you_mean(key.value, keys)}")
            if key.value in table:
                raise self._error(key, f"'{key.value}' exists already")
            table[str(key.value)] = value
        return table

    def _value(self, node: Any, factor: float, quantity: str) -> FileValue:
        if factor == 0.0:
            known = ", ".join(UNITS[quantity])
            raise self._error(node, f"units.{quantity} is not stated: one of {known}")
        if node.id != "scalar":
            raise self._error(node, "a number is expected here")
        value = number(str(node.value), _where(node), self._source)
        return FileValue(factor * value, quantity, _where(node))

    def _error(self, node: Any, text: str) -> KeyframeError:
        return KeyframeError(self._source, _where(node), text)


def _where(node: Any) -> FilePosition:
    if node is None:
        return FilePosition(1, 1)
    return FilePosition(node.start_mark.line + 1, node.start_mark.column + 1)
