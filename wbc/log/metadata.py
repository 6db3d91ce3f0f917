"""Collects parameters and versions as text for the metadata of a log."""

from __future__ import annotations

import importlib.metadata
import json
import platform
import shlex
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from datetime import datetime, timezone
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np

import wbc

_PACKAGES = (
    "pin", "numpy", "mujoco", "daqp", "qpsolvers", "osqp", "numba", "mcap",
)  # fmt: skip
STRETCH = "stretch"  #: name of the table that only a part of a session has, see `write_log`
_SMALL = 64  # numbers: larger arrays are data, not parameters


@dataclass(frozen=True)
class Metadata:
    """Data that a log holds once, beside its messages.

    Attributes:
        tables: Maps each table name to its names and values; stored as MCAP metadata.
        files: Maps each file name to its text; stored as MCAP attachments.
    """

    tables: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)


def versions() -> dict[str, str]:
    """Return the versions of this library, of Python and of the packages that it uses."""
    found = {
        "wbc": wbc.__version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
    }
    for name in _PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            continue
    return found


def run_metadata(controller: Any, plant: Any) -> Metadata:
    """Return the parameters of a run: controller, plant and command line.

    Every public attribute that is a number, a string or a dataclass of these counts as a
    parameter, for any class of controller.
    """
    run = {
        "began": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "command": shlex.join([_program(sys.argv[0]), *sys.argv[1:]]),
        "dt": str(plant.dt),
    }
    tables = {"run": run, "controller": dict(_parameters(controller)), "plant": {}}
    tables["plant"] = dict(_parameters(plant))
    tables["tasks"] = {name: _gains(task) for name, task in _tasks(controller)}
    terrain = getattr(plant, "terrain", None)
    boxes = [] if terrain is None else terrain.boxes().tolist()
    return Metadata(
        {name: table for name, table in tables.items() if table},
        {"terrain.json": json.dumps({"boxes": boxes})},
    )


def _program(path: str) -> str:
    name = Path(path).name
    return "wbc" if name == "__main__.py" and Path(path).parent.name == "wbc" else name


def _parameters(thing: Any, prefix: str = "") -> Iterator[tuple[str, str]]:
    """Yield names and values; nested dataclasses and controllers give dotted names."""
    yield f"{prefix}type", type(thing).__name__
    for name, value in _attributes(thing):
        if (text := _plain(value)) is not None:
            yield prefix + name, text
        elif (is_dataclass(value) and not hasattr(value, "model")) or hasattr(value, "step"):
            yield from _parameters(value, f"{prefix}{name}.")
        elif name == "solver":
            yield prefix + name, str(getattr(value, "name", type(value).__name__))


def _attributes(thing: Any) -> list[tuple[str, Any]]:
    names = [f.name for f in fields(thing)] if is_dataclass(thing) else list(_dict(thing))
    return [(name, getattr(thing, name)) for name in names if not name.startswith("_")]


def _dict(thing: Any) -> Mapping[str, Any]:
    found: Mapping[str, Any] = getattr(thing, "__dict__", {})
    return found


def _plain(value: Any) -> str | None:
    if value is None or isinstance(value, (bool, int, float, str)):
        return str(value)
    if isinstance(value, Enum):
        return str(value.value)
    if isinstance(value, np.ndarray):
        return str(value.tolist()) if value.size <= _SMALL else None
    if isinstance(value, (tuple, list)) and all(_plain(x) is not None for x in value):
        return str(list(value)) if len(value) <= _SMALL else None
    return None


def _tasks(controller: Any) -> list[tuple[str, Any]]:
    for holder in (controller, *_dict(controller).values()):
        tasks = getattr(getattr(holder, "controller", holder), "tasks", None)
        if isinstance(tasks, list):
            return [(str(getattr(task, "name", type(task).__name__)), task) for task in tasks]
    return []


def _gains(task: Any) -> str:
    """Return weight and gains of a task; a single number where all rows are equal."""
    words = [type(task).__name__]
    for name in ("weight", "kp", "kd"):
        values = np.unique(getattr(task, name, ()))
        if values.size:
            words.append(f"{name} {' … '.join(f'{x:.6g}' for x in values[[0, -1][: values.size]])}")
    return ", ".join(words)
