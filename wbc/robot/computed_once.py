"""What is computed once per robot: a robot is immutable, so that it stays as it is."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TypeVar
from weakref import WeakKeyDictionary

from wbc.robot.robot_model import RobotModel

R = TypeVar("R", bound=RobotModel)
T = TypeVar("T")


def computed_once(compute: Callable[[R], T]) -> Callable[[R], T]:
    """Have a function of a robot compute its value once for each robot that lives.

    Args:
        compute: the function. A value that holds its robot keeps it from being freed.
    """
    known: WeakKeyDictionary[R, T] = WeakKeyDictionary()

    @functools.wraps(compute)
    def value_of(robot: R) -> T:
        if robot not in known:
            known[robot] = compute(robot)
        return known[robot]

    return value_of
