"""What the caller of `load` states, laid over what the data file states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from wbc.robot.data import RobotData


def with_stated(data: RobotData, stated: Mapping[str, Any]) -> RobotData:
    """The data with the caller's statements; those that are None say nothing."""
    changes = {key: value for key, value in stated.items() if value is not None}
    if "srdf" in changes:
        changes["srdf"] = Path(changes["srdf"]).expanduser().resolve()
        # An SRDF is given for its posture; the data file's own would hide it.
        changes.setdefault("nominal_posture", {})
    if "fixed_joints" in changes:
        changes["fixed_joints"] = tuple(changes["fixed_joints"])
    return replace(data, **changes) if changes else data
