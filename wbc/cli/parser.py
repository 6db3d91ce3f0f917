"""Parsing of the command line: `argparse` with one-line errors, and checked values."""

from __future__ import annotations

import argparse
import math
import os
from pathlib import Path
from typing import NamedTuple, NoReturn

FELL = ERRORS = 1
BAD_INPUT = 2
INTERRUPTED = 130


class Push(NamedTuple):
    """A push on the torso.

    Attributes:
        time: when it sets in, s.
        impulse: N·s, world axes; the robot starts heading along +x.
    """

    time: float
    impulse: tuple[float, float, float]


class Parser(argparse.ArgumentParser):
    """An argument parser that says what is wrong in one line."""

    def __init__(self, **options: object) -> None:
        options.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        options.setdefault("allow_abbrev", False)
        super().__init__(**options)  # type: ignore[arg-type]

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"{self.prog}: {message} (see {self.prog} --help)\n")


def number(text: str) -> float:
    """A finite number."""
    value = _float(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"'{text}' is not a finite number")
    return value


def seconds(text: str) -> float:
    """A positive time."""
    value = number(text)
    if value <= 0.0:
        raise argparse.ArgumentTypeError(f"{text} s is not a positive time")
    return value


def seed(text: str) -> int:
    """A whole number from 0 on."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from 0 on")
    return int(text)


def push(text: str) -> Push:
    """`"T IX IY IZ"`."""
    parts = text.replace(",", " ").split()
    if len(parts) != 4:
        raise argparse.ArgumentTypeError(
            f"'{text}' has {len(parts)} numbers where a push has four, in quotes: "
            '"T IX IY IZ", the time in s and the impulse in N·s'
        )
    time, *impulse = (number(part) for part in parts)
    if time < 0.0:
        raise argparse.ArgumentTypeError(f"'{text}': the time of a push must not be negative")
    return Push(time, (impulse[0], impulse[1], impulse[2]))


def output(text: str) -> Path:
    """A file that can be written; its folder is made."""
    path = Path(text).expanduser()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise argparse.ArgumentTypeError(f"cannot make {path.parent}: {error.strerror}") from None
    if path.is_dir():
        raise argparse.ArgumentTypeError(f"{path} is a folder; give the path of a file")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise argparse.ArgumentTypeError(f"{path} may not be written")
    return path


def _float(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number") from None
