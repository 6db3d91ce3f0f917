"""Orders on their way back from the node to the loop, which never waits for them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from wbc.process import SharedMemory

_HEAD = 20  # numbers before the joints'


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
        rate: of ticks, Hz, that the node needs to be shown at the least.
        motions: how many motions have been asked for.
        slot: where on the shelf the last one lies.
        size: of it there, bytes.
        stands: how many times it was told to leave off and stand.
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
    rate: float = float("inf")
    motions: int = 0
    slot: int = 0
    size: int = 0
    stands: int = 0

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
            orders.rate,
            orders.motions,
            orders.slot,
            orders.size,
            orders.stands,
            *[0.0] * 3,
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
        head = iter(numbers[:_HEAD].tolist())
        self._seen = sequence
        self._latest = Orders(
            joints=numbers[_HEAD:],
            velocity=(next(head), next(head), next(head)),
            velocity_until=next(head),
            arrival=next(head),
            joint_speed=next(head),
            pushes=int(next(head)),
            impulse=(next(head), next(head), next(head)),
            push_duration=next(head),
            resets=int(next(head)),
            rate=next(head),
            motions=int(next(head)),
            slot=int(next(head)),
            size=int(next(head)),
            stands=int(next(head)),
        )
        return self._latest

    @property
    def latest(self) -> Orders:
        """Those that were looked at last."""
        return self._latest

    def close(self) -> None:
        """Give up the descriptor. The memory goes with the last mapping."""
        self._memory.close()
