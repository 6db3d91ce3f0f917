"""Types of command-line arguments: each parses a text and refuses invalid ones."""

from __future__ import annotations

import argparse
import functools
import math
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, NamedTuple

#: Start of a push, s, and its impulse, N·s, in world axes; the robot starts heading along +x.
ScheduledPush = tuple[float, tuple[float, float, float]]


_LEAST_SPACE = 64 * 1024  # bytes on a disk; no output is smaller than some of them


class Argument(NamedTuple):
    """The notation of an argument on the command line; the metadata of an annotated type.

    Attributes:
        metavar: name of the value in the help; a tuple for as many values.
        parse: converts the text of a value.
        flag: flag of an option; by default the name of the parameter with hyphens.
        nargs: number of values of the option, as for `argparse`.
    """

    metavar: str | tuple[str, ...]
    parse: Callable[[str], Any] = str
    flag: str = ""
    nargs: str = ""


def number(text: str) -> float:
    """Parse a finite number."""
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number") from None
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"'{text}' is not a finite number")
    return value


def _seconds(text: str) -> float:
    """Parse a positive time, s."""
    value = number(text)
    if value <= 0.0:
        raise argparse.ArgumentTypeError(f"{text} s is not a positive time")
    return value


def whole_number(text: str, low: int = 0, high: float = math.inf) -> int:
    """Parse an integer within bounds."""
    if not (text.isdecimal() and low <= int(text) <= high):
        bounds = f"{low} or greater" if high == math.inf else f"{low} to {high}"
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number, {bounds}")
    return int(text)


def positive_number(text: str) -> int:
    """Parse a positive integer."""
    return whole_number(text, 1)


def _push(text: str) -> ScheduledPush:
    """Parse `"T IX IY IZ"`."""
    parts = text.replace(",", " ").split()
    if len(parts) != 4:
        raise argparse.ArgumentTypeError(
            f"'{text}' has {len(parts)} numbers, but a push has four, in quotes: "
            '"T IX IY IZ", the time in s and the impulse in N·s'
        )
    time, x, y, z = (number(part) for part in parts)
    if time < 0.0:
        raise argparse.ArgumentTypeError(f"'{text}': the time of a push must not be negative")
    return time, (x, y, z)


def joint_value(text: str) -> tuple[str, float]:
    """Parse `JOINT=VALUE`."""
    name, equals, value = text.rpartition("=")
    if not (name and equals):
        raise argparse.ArgumentTypeError(f"'{text}' is not of the form JOINT=VALUE")
    return name, number(value)


def _size(text: str) -> tuple[int, int]:
    """Parse `WIDTHxHEIGHT`, pixels."""
    width, cross, height = text.lower().partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise argparse.ArgumentTypeError(f"'{text}' is not a size in pixels, such as 960x540")
    return int(width), int(height)


def _camera(text: str) -> tuple[float, float, float]:
    """Parse `"AZIMUTH ELEVATION DISTANCE"`."""
    parts = text.replace(",", " ").split()
    if len(parts) != 3:
        raise argparse.ArgumentTypeError(
            f"'{text}' has {len(parts)} numbers, but a camera has three, in quotes: azimuth and "
            "elevation in degrees, distance in m"
        )
    azimuth, elevation, distance = (number(part) for part in parts)
    return azimuth, elevation, distance


def _output_file(text: str) -> Path:
    """Parse the path of a file to write; check that it can be written, and create its folder."""
    path = Path(text).expanduser()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise argparse.ArgumentTypeError(f"cannot create {path.parent}: {error.strerror}") from None
    if path.is_dir():
        raise argparse.ArgumentTypeError(f"{path} is a folder; give the path of a file")
    existed = path.exists()
    try:
        # Permissions alone do not tell: a file system may be read-only, and root may do anything.
        os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_NONBLOCK))
    except OSError as error:
        raise argparse.ArgumentTypeError(f"cannot write {path}: {error.strerror}") from None
    if not existed:
        path.unlink()
    is_device = path.exists() and not path.is_file()
    if not is_device and shutil.disk_usage(path.resolve().parent).free < _LEAST_SPACE:
        raise argparse.ArgumentTypeError(f"cannot write {path}: its disk is full")
    return path


RobotName = Annotated[str, Argument("NAME|FILE")]
PolicyFolder = Annotated[Path, Argument("DIR", Path)]
Seconds = Annotated[float, Argument("S", _seconds)]
Port = Annotated[int, Argument("N", functools.partial(whole_number, high=65535))]
Priority = Annotated[int, Argument("N", functools.partial(whole_number, high=99))]
Pushes = Annotated[tuple[ScheduledPush, ...], Argument('"T IX IY IZ"', _push)]
OutputFile = Annotated[Path, Argument("FILE", _output_file)]
LogFile = Annotated[Path, Argument("FILE.mcap", _output_file)]
VideoFile = Annotated[Path, Argument("FILE.mp4|FILE.gif", _output_file)]
VideoSize = Annotated[tuple[int, int], Argument("WxH", _size)]
VideoCamera = Annotated[
    tuple[float, float, float], Argument('"AZIMUTH ELEVATION DISTANCE"', _camera)
]
