"""Command line parsing: `argparse` with one-line errors, and types that check their values."""

from __future__ import annotations

import argparse
import math
import os
import textwrap
from pathlib import Path
from typing import NamedTuple, NoReturn

from wbc.cli.exit_codes import BAD_INPUT


class PushOption(NamedTuple):
    """A push on the torso, given by `--push`.

    Attributes:
        time: start of the push, s.
        impulse: impulse, N·s, in world axes; the robot starts heading along +x.
    """

    time: float
    impulse: tuple[float, float, float]


class _HelpFormatter(argparse.RawDescriptionHelpFormatter):
    """Wraps texts of one paragraph; keeps the lines of longer ones."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        if "\n" in text.strip():
            return super()._fill_text(text, width, indent)
        return textwrap.fill(text, width, initial_indent=indent, subsequent_indent=indent)


class Parser(argparse.ArgumentParser):
    """An argument parser that reports errors in one line."""

    def __init__(self, **options: object) -> None:
        options.setdefault("formatter_class", _HelpFormatter)
        options.setdefault("allow_abbrev", False)
        super().__init__(**options)  # type: ignore[arg-type]

    def error(self, message: str) -> NoReturn:
        """Exit with the message; see `argparse.ArgumentParser.error`."""
        self.exit(BAD_INPUT, f"{self.prog}: {message} (see {self.prog} --help)\n")


def number(text: str) -> float:
    """Parse a finite number."""
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number") from None
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"'{text}' is not a finite number")
    return value


def seconds(text: str) -> float:
    """Parse a positive time, s."""
    value = number(text)
    if value <= 0.0:
        raise argparse.ArgumentTypeError(f"{text} s is not a positive time")
    return value


def seed(text: str) -> int:
    """Parse a non-negative integer."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number, 0 or greater")
    return int(text)


def push(text: str) -> PushOption:
    """Parse `"T IX IY IZ"`."""
    parts = text.replace(",", " ").split()
    if len(parts) != 4:
        raise argparse.ArgumentTypeError(
            f"'{text}' has {len(parts)} numbers, but a push has four, in quotes: "
            '"T IX IY IZ", the time in s and the impulse in N·s'
        )
    time, *impulse = (number(part) for part in parts)
    if time < 0.0:
        raise argparse.ArgumentTypeError(f"'{text}': the time of a push must not be negative")
    return PushOption(time, (impulse[0], impulse[1], impulse[2]))


def joint_value(text: str) -> tuple[str, float]:
    """Parse `JOINT=VALUE`."""
    name, equals, value = text.rpartition("=")
    if not (name and equals):
        raise argparse.ArgumentTypeError(f"'{text}' is not of the form JOINT=VALUE")
    return name, number(value)


def output_file(text: str) -> Path:
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
    return path
