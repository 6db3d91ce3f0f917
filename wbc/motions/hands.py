"""A hand that can be led to places."""

from __future__ import annotations

from wbc.motions.anatomy import Arm
from wbc.motions.intent import Target
from wbc.walking import Walker


class Hand:
    def __init__(self, walker: Walker, arm: Arm) -> None:
        self.arm = arm
        self.engaged = False
        self.target: Target | None = None

    def reset(self) -> None:
        pass

    def release(self, duration: float) -> None:
        pass
