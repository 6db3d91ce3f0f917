"""Packing prepared motions, to plan in one process and play in another."""

from __future__ import annotations

import io
import pickle
from typing import Any

from wbc.errors import MotionError
from wbc.motions.engine.motion import Motion
from wbc.robot import Robot

_ROBOT = "robot"


class _Pickler(pickle.Pickler):
    """Leaves the robot out: the other process has its own."""

    def __init__(self, file: io.BytesIO, robot: Robot) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._robot = robot

    def persistent_id(self, value: Any) -> str | None:
        return _ROBOT if value is self._robot else None


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, robot: Robot) -> None:
        super().__init__(file)
        self._robot = robot

    def persistent_load(self, _: Any) -> Robot:
        return self._robot


def check_importable(motion: type[Motion]) -> None:
    """Refuse a motion type that another process could not import.

    Raises:
        MotionError: it is not defined at the top level of an importable module.
    """
    if motion.__module__ == "__main__" or "<locals>" in motion.__qualname__:
        raise MotionError(
            f"the motion '{motion.name}' is defined where another process cannot import it "
            f"({motion.__module__}.{motion.__qualname__}): put it in a module of its own"
        )


def pack(motion: Motion, robot: Robot) -> bytes:
    """Prepare a motion, and pickle it together with its plans: 0.1 to 130 kB.

    Args:
        motion: may be prepared already.
        robot: the robot that is to play it.

    Raises:
        MotionError: the robot cannot do it, or its plans cannot be pickled.
    """
    motion.prepare(robot)
    file = io.BytesIO()
    try:
        _Pickler(file, robot).dump(motion)
    except (pickle.PicklingError, TypeError, AttributeError) as error:
        raise MotionError(
            f"{motion.name} cannot be sent to another process: {error}; keep functions and open "
            "files out of what its once_per_robot methods return"
        ) from error
    return file.getvalue()


def unpack(data: bytes, robot: Robot) -> Motion:
    """Return a packed motion, prepared; takes well below a millisecond.

    Args:
        data: result of `pack` from a trusted process: unpickling may run any code.
        robot: the same robot in this process.
    """
    motion: Motion = _Unpickler(io.BytesIO(data), robot).load()
    return motion
