"""The status of the loop that pages show, by the ticks since the last one."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from wbc.runtime.mode import Mode


def tick_status(ticks: np.ndarray) -> dict[str, Any]:
    """Return the last tick's status, with the largest DCM error and tick time of all ticks."""
    last = ticks[-1]
    running = ticks[ticks["mode"] == Mode.RUNNING]
    times = running["estimator_time"] + running["controller_time"]
    return {
        "stamp": round(time.monotonic(), 3),
        "time": round(float(last["time"]), 4),
        "mode": Mode(int(last["mode"])).name.lower(),
        "dcm_error": _largest(running["dcm_error"]),
        "tick_time": _largest(times),
        "velocity": [_finite(x) for x in last["velocity_command"]],
        "heading": _finite(last["heading"]),
        "playing": int(last["motion_playing"]),
        "pushes": int(last["pushes_decided"]),
        "survived": int(last["pushes_survived"]),
        "run": int(last["run"]),
    }


def _largest(values: np.ndarray) -> float | None:
    return _finite(np.max(values, initial=0.0, where=np.isfinite(values)))


def _finite(value: float) -> float | None:
    return round(float(value), 6) if np.isfinite(value) else None
