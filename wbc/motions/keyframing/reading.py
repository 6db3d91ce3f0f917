"""Reading keyframe files, CSV or YAML."""

from __future__ import annotations

import stat
from pathlib import Path

from wbc.errors import MotionError
from wbc.motions.keyframing.csv_file import from_csv
from wbc.motions.keyframing.keyframe import FilePosition, Keyframe, KeyframeError
from wbc.motions.keyframing.yaml_file import from_yaml

_MAX_DURATION = 600.0  # s
_MAX_SIZE = 4 << 20  # bytes of a file
_READERS = {".csv": from_csv, ".yaml": from_yaml, ".yml": from_yaml}


def read_keyframes(path: Path) -> list[Keyframe]:
    """Read the keyframes of a file, whose suffix gives the format.

    Raises:
        KeyframeError: the content is malformed; with line and column.
        MotionError: the file cannot be read.
        MissingExtra: the file is YAML and PyYAML is not installed.
    """
    read = _READERS.get(path.suffix.lower())
    if read is None:
        raise MotionError(f"keyframes: {path.name} must end in {' or '.join(_READERS)}")
    frames = read(_text(path), path.name)
    before = 0.0
    for frame in frames:
        if frame.time.number <= before:
            raise KeyframeError(
                path.name,
                frame.time.where,
                f"time {frame.time.number:g} s must be after {before:g} s: times must increase, "
                "and the robot stands at 0 s",
            )
        before = frame.time.number
    if before > _MAX_DURATION:
        raise KeyframeError(
            path.name,
            frames[-1].time.where,
            f"time {before:g} s: a motion lasts at most {_MAX_DURATION:g} s",
        )
    return frames


def _text(path: Path) -> str:
    try:
        # A pipe would block for good, and a device may be endless.
        if not stat.S_ISREG(path.stat().st_mode):
            raise MotionError(f"keyframes: {path} is not a regular file")
        if path.stat().st_size > _MAX_SIZE:
            raise MotionError(f"keyframes: {path} is larger than {_MAX_SIZE >> 20} MiB")
        return path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise MotionError(f"keyframes: cannot read {path}: {error.strerror}") from None
    except UnicodeDecodeError as error:
        before = error.object[: error.start].decode("utf-8")
        where = FilePosition(before.count("\n") + 1, len(before) - before.rfind("\n"))
        wrong = error.object[error.start]
        text = f"byte 0x{wrong:02x} is not UTF-8: save the file as UTF-8 text"
        raise KeyframeError(path.name, where, text) from None
