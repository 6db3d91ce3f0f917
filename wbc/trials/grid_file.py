"""Reads grids from TOML and writes them: the keys are the fields of the dataclasses."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from wbc.errors import MissingExtra, did_you_mean, short_repr
from wbc.trials.condition import Condition
from wbc.trials.controllers import ControllerSpec
from wbc.trials.disturbance import ForceDisturbance, KickDisturbance, PushDisturbance
from wbc.trials.errors import TrialError
from wbc.trials.grid import Grid, RobotCases
from wbc.trials.toml_file import read_toml

#: Classes of the lists of tables in a grid.
_TABLES: Mapping[str, type] = {
    "robots": RobotCases,
    "controllers": ControllerSpec,
    "conditions": Condition,
}
_DISTURBANCES: Mapping[Any, type] = {
    "push": PushDisturbance,
    "force": ForceDisturbance,
    "kick": KickDisturbance,
}


def read_grid(path: str | Path) -> Grid:
    """Read a grid from a TOML file.

    Raises:
        TrialError: the file cannot be read, is no TOML, or does not describe a grid; the text
            names every wrong key and value.
    """
    return parse_grid(read_toml(Path(path)), str(path))


def parse_grid(content: Mapping[str, Any], source: str = "grid") -> Grid:
    """Return the grid that a table of TOML describes.

    Args:
        content: the table.
        source: its name in messages.

    Raises:
        TrialError: it does not describe a grid; the text names every wrong key and value.
        MissingExtra: `pydantic` is not installed.
    """
    pydantic = _import_pydantic()
    rest, given = dict(content), content.get("disturbance", {"kind": "push"})
    kind = given.get("kind") if isinstance(given, Mapping) else None
    if kind not in _DISTURBANCES:
        raise TrialError(
            f"{source}: disturbance.kind must be one of {', '.join(_DISTURBANCES)}, "
            f"not {short_repr(kind)}"
        )
    messages: dict[str, None] = {}

    def validated(place: str, wanted: type, value: Any) -> Any:
        try:
            # Strict JSON: lists become tuples, but no text becomes a number.
            text = json.dumps(value)
            adapter = pydantic.TypeAdapter(wanted)
            return adapter.validate_json(text, strict=True, extra="forbid")
        except TypeError as error:
            raise TrialError(f"{source}: dates and times have no place in a grid") from error
        except pydantic.ValidationError as error:
            messages.update((_message(place, wanted, one), None) for one in error.errors())

    rest.pop("disturbance", None)
    disturbance = validated("disturbance", _DISTURBANCES[kind], given)
    grid: Grid = validated("", Grid, rest)
    if messages:
        raise TrialError(f"{source}: {'; '.join(messages)}")
    return replace(grid, disturbance=disturbance)


def grid_to_json(grid: Grid) -> str:
    """Return a grid as JSON, defaults included; `parse_grid` reads its content back."""
    text: bytes = _import_pydantic().TypeAdapter(Grid).dump_json(grid, exclude_none=True)
    return text.decode()


def write_grid(grid: Grid, path: str | Path) -> None:
    """Write a grid as TOML.

    Raises:
        TrialError: the file cannot be written.
        MissingExtra: `tomli-w` is not installed.
    """
    try:
        import tomli_w
    except ImportError as error:
        raise MissingExtra("tomli_w", "trials") from error
    try:
        table = (
            _import_pydantic()
            .TypeAdapter(Grid)
            .dump_python(grid, mode="json", exclude_none=True, exclude_defaults=True)
        )
        if "disturbance" in table:
            table["disturbance"]["kind"] = grid.disturbance.kind
        Path(path).write_text(tomli_w.dumps(table), encoding="utf-8")
    except OSError as error:
        raise TrialError(f"cannot write {path}: {error.strerror}") from error


def _import_pydantic() -> Any:
    try:
        import pydantic
    except ImportError as error:
        raise MissingExtra("pydantic", "trials") from error
    return pydantic


def _message(table: str, wanted: type, error: Mapping[str, Any]) -> str:
    """Return one error of pydantic in words, e.g. `unknown key 'conditions[0].latncy'; …`."""
    steps = [table, *error["loc"]] if table else list(error["loc"])
    given = error["input"]
    if "velocities" in steps:
        steps = steps[: steps.index("velocities") + 2]
    place = "".join(f"[{s}]" if isinstance(s, int) else f".{s}" for s in steps).lstrip(".")
    kind = error["type"]
    if kind == "unexpected_keyword_argument":
        owner: Any = wanted if table or len(steps) < 2 else _TABLES.get(str(steps[0]), wanted)
        near = did_you_mean(str(steps[-1]), sorted(owner.__dataclass_fields__))
        return f"unknown key '{place}'{near}"
    if kind == "value_error":
        text = str(error["ctx"]["error"])
        return f"{place}: {text}" if place else text
    if "velocities" in steps:
        return f"{place} must be a forward velocity, or three of forward, left and turn"
    if kind == "missing":
        return f"'{place}' is missing"
    return f"{place}: {error['msg'][:1].lower()}{error['msg'][1:]}, not {short_repr(given)}"
