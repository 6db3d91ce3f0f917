"""Orders on their way back from the node to the loop, which never waits for them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from wbc.process import SharedMemory

_HEAD = 16  # numbers before the joints'


@dataclass
class Orders:
    """What is wanted of the loop.

    Times are those of `time.monotonic`, which all processes of a machine share.

    Attributes:
        joints: (na,) wanted joint positions, rad; NaN: none.
        velocity: forward, left (m/s) and turn left (rad/s), in the heading frame.
        velocity_until: when it ends, s: whoever wants the robot to walk must keep saying so.
        arrival: when the joints should be there, s.
        joint_speed: of the fastest of them, rad/s.
        pushes: how many pushes have been asked for.
        impulse: of the last push, N·s, world axes.
        push_duration: of the last push, s.
        resets: how many resets have been asked for.
    """

    joints: np.ndarray
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    velocity_until: float = 0.0
    arrival: float = 0.0
    joint_speed: float = 1.0
    pushes: int = 0
    impulse: tuple[float, float, float] = (0.0, 0.0, 0.0)
    push_duration: float = 0.1
    resets: int = 0

    @staticmethod
    def none(na: int) -> Orders:
        """Nothing is wanted of so many joints."""
        return Orders(np.full(na, np.nan))


@dataclass
class Mailbox:
    """One set of orders in shared memory: the node posts, the loop looks.

    Args:
        na: number of joints.
        descriptor: of a mailbox made by another process; None makes a new one.
    """

    na: int
    descriptor: int | None = None
    _latest: Orders = field(init=False)

    def __post_init__(self) -> None:
        self._memory = SharedMemory(8 * (1 + _HEAD + self.na), self.descriptor)
        self.descriptor = self._memory.descriptor
        view = self._memory.view
        self._sequence = view.cast("Q")
        self._numbers = np.frombuffer(view, np.float64, _HEAD + self.na, 8)
        self._seen = 0
        self._latest = Orders.none(self.na)

    def post(self, orders: Orders) -> None:
        """Put orders in. Only one process may."""
        sequence = int(self._sequence[0])
        self._sequence[0] = sequence + 1  # odd: being written
        self._numbers[:_HEAD] = (
            *orders.velocity,
            orders.velocity_until,
            orders.arrival,
            orders.joint_speed,
            orders.pushes,
            *orders.impulse,
            orders.push_duration,
            orders.resets,
            *[0.0] * 4,
        )
        self._numbers[_HEAD:] = orders.joints
        self._sequence[0] = sequence + 2

    def look(self) -> Orders:
        """The latest orders; those before when they are just being written."""
        sequence = int(self._sequence[0])
        if sequence == self._seen or sequence % 2:
            return self._latest
        numbers = self._numbers.copy()
        if int(self._sequence[0]) != sequence:
            return self._latest
        x, y, turn, until, arrival, speed, pushes, ix, iy, iz, duration, resets = numbers[
            :12
        ].tolist()
        self._seen = sequence
        self._latest = Orders(
            joints=numbers[_HEAD:],
            velocity=(x, y, turn),
            velocity_until=until,
            arrival=arrival,
            joint_speed=speed,
            pushes=int(pushes),
            impulse=(ix, iy, iz),
            push_duration=duration,
            resets=int(resets),
        )
        return self._latest

    def close(self) -> None:
        """Give up the descriptor. The memory goes with the last mapping."""
        self._memory.close()
