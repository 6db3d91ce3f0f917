"""A wire to the stand-in robot within this process, in lockstep with its simulated time."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from wbc.hardware.unitree.stand_in import PERIOD, G1StandIn

#: Changes a message on the wire: returns what arrives of it, in order; nothing if it is lost.
Disturbance = Callable[[float, bytes], list[bytes]]


def undisturbed(time: float, data: bytes) -> list[bytes]:
    """Return the message as it is."""
    return [data]


class LockstepTransport:
    """The controller's side of a wire that loses no time: deterministic, as fast as possible.

    Args:
        stand_in: the robot.

    Attributes:
        on_state: disturbs state messages; it is called with the robot's time, s, and the bytes.
        on_command: disturbs commands likewise.
    """

    def __init__(
        self,
        stand_in: G1StandIn,
        *,
        on_state: Disturbance = undisturbed,
        on_command: Disturbance = undisturbed,
    ) -> None:
        self._stand_in = stand_in
        self.on_state, self.on_command = on_state, on_command
        self._arrived: deque[bytes] = deque()

    def now(self) -> float:
        """Return the robot's time, s."""
        return self._stand_in.plant.time

    def receive(self, timeout: float) -> bytes | None:
        """Advance the robot until a message arrives; None after `timeout` s of its time."""
        end = self.now() + timeout + 0.5 * PERIOD
        while not self._arrived:
            if self.now() + PERIOD > end:
                return None
            self.advance()
        return self._arrived.popleft()

    def advance(self) -> None:
        """Advance the robot by one period, whatever the controller does meanwhile."""
        self._stand_in.step()
        data = self._stand_in.state_message()
        self._arrived.extend(self.on_state(self.now(), data))

    def send(self, data: bytes) -> None:
        """Deliver a command to the robot."""
        for message in self.on_command(self.now(), data):
            self._stand_in.take(message)

    def close(self) -> None:
        """Do nothing: the robot belongs to the caller."""
