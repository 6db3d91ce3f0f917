"""Reading keyframe files of either kind."""

from __future__ import annotations

from pathlib import Path

from wbc.errors import MotionError
from wbc.motions.keyframing.csv_file import from_csv
from wbc.motions.keyframing.keyframe import Keyframe, KeyframeError
from wbc.motions.keyframing.yaml_file import from_yaml


def read_keyframes(path: Path) -> list[Keyframe]:
    """Read a file, by its ending.

    Raises:
        KeyframeError: it cannot be understood; with line and column.
        MotionError: it cannot be read.
        MissingExtra: it is YAML and PyYAML is not installed.
    """
    try:
        text = path.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise MotionError(f"keyframes: cannot read {path}: {error}") from None
    if path.suffix.lower() == ".csv":
        frames = from_csv(text, path.name)
    elif path.suffix.lower() in (".yaml", ".yml"):
        frames = from_yaml(text, path.name)
    else:
        raise MotionError(f"keyframes: {path.name} must end in .csv, .yaml or .yml")
    before = 0.0
    for frame in frames:
        if frame.time.number <= before:
            raise KeyframeError(
                path.name,
                frame.time.where,
                f"time {frame.time.number:g} s must be after {before:g} s: times grow, and the "
                "robot stands at 0 s",
            )
        before = frame.time.number
    return frames
