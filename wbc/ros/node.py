"""`Node`: a process that a ROS 2 system takes for one of its own."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Protocol

from wbc.closeable import Closeable
from wbc.messages import Message
from wbc.ros import names
from wbc.ros.endpoints import Info, Listener, Publisher, Reader, Subscription
from wbc.ros.errors import RosError
from wbc.ros.network import Network
from wbc.ros.participant import Participant
from wbc.ros.qos import DEFAULT, SERVICES, Qos
from wbc.ros.services import Client, Reply, Service

_LONGEST_WAIT = 0.1  # s: Ctrl-C is heard at least as often
_SOON = 0.005  # s


class Worker(Protocol):
    """Something with a reader that has work to do when messages have come."""

    reader: Reader

    @property
    def impatient(self) -> bool:
        """Whether it wants to work again soon, messages or not."""

    def work(self) -> None:
        """Do it, without waiting."""


class Timer:
    """Calls a function at a rate; `Node.timer` makes it.

    Attributes:
        period: s; may be changed.
    """

    def __init__(self, period: float, callback: Callable[[], None]) -> None:
        self.period = period
        self.callback = callback
        self.due = time.monotonic() + period
        self.cancelled = False

    def cancel(self) -> None:
        """Never call again."""
        self.cancelled = True

    def call(self, now: float) -> None:
        """Call, and set the next time; what was missed is not made up for."""
        self.due = max(self.due + self.period, now)
        self.callback()


class Node(Closeable):
    """A node of ROS 2, without ROS 2.

    It lives in one thread: messages, requests and timers are served in `spin`.

    Example:
        >>> node = Node("talker")
        >>> publisher = node.publisher("std_msgs/msg/String", "chatter")
        >>> timer = node.timer(0.5, lambda: publisher.publish(String(data="hello")))
        >>> node.spin()

    Args:
        name: of the node.
        namespace: in which it and its relative names are.
        network: domain and interface; from the environment when left out.

    Attributes:
        name: of the node.
        space: its namespace, with a leading slash.

    Raises:
        MissingExtra: `cyclonedds` is not installed.
        RosError: the name is none, or the domain cannot be joined.
    """

    def __init__(self, name: str, *, namespace: str = "/", network: Network | None = None) -> None:
        self.name = names.node_name(name)
        self.space = names.namespace(namespace)
        self.participant = Participant(self.space, name, network or Network.of())
        from cyclonedds.core import WaitSet

        self._waiting: Any = WaitSet(self.participant.dds)
        self._publishers: list[Publisher] = []  # they would leave DDS if nobody held them
        self._workers: list[Worker] = []
        self._timers: list[Timer] = []
        self._open = True

    @property
    def full_name(self) -> str:
        """Namespace and name."""
        return f"{self.space.rstrip('/')}/{self.name}"

    def resolve(self, name: str) -> str:
        """The full name of a topic or service, see `wbc.ros.names.resolve`."""
        return names.resolve(name, self.name, self.space)

    def publisher(self, type_name: str, topic: str, qos: Qos = DEFAULT) -> Publisher:
        """A publisher.

        Args:
            type_name: `pkg/msg/Name`.
            topic: absolute, relative or private.
            qos: quality of service.

        Raises:
            MessageError: there is no such type.
            NameInvalid: there can be no such topic.
        """
        made = Publisher(self.participant, self.resolve(topic), type_name, qos)
        self.participant.add(writers=(made.writer.gid,))
        self._publishers.append(made)
        return made

    def subscription(
        self,
        type_name: str,
        topic: str,
        callback: Callable[[Any, Info], None],
        qos: Qos = DEFAULT,
    ) -> Subscription:
        """A subscription; its callback gets each message and an `Info` about it.

        Raises:
            MessageError: there is no such type.
            NameInvalid: there can be no such topic.
        """
        made = Subscription(self.participant, self.resolve(topic), type_name, callback, qos)
        self.participant.add(readers=(made.reader.gid,))
        self.attend(made)
        return made

    def listen(
        self,
        dds_type_name: str,
        topic: str,
        callback: Callable[[bytes, Info], None],
        qos: Qos = DEFAULT,
    ) -> Listener:
        """A subscription to messages of a type that need not be known here.

        Args:
            dds_type_name: e.g. `std_msgs::msg::dds_::String_`.
            topic: absolute, relative or private.
            callback: gets each message's bytes, header included, and an `Info` about it.
            qos: quality of service.

        Raises:
            NameInvalid: there can be no such topic.
        """
        made = Listener(self.participant, self.resolve(topic), dds_type_name, callback, qos)
        self.participant.add(readers=(made.reader.gid,))
        self.attend(made)
        return made

    def service(
        self,
        type_name: str,
        name: str,
        answer: Callable[[Any], Message],
        qos: Qos = SERVICES,
    ) -> Service:
        """A service; `answer` makes a response of each request.

        Raises:
            MessageError: there is no such type.
            NameInvalid: there can be no such service.
        """
        return self.service_with_reply(
            type_name, name, lambda request, reply: reply.send(answer(request)), qos
        )

    def service_with_reply(
        self,
        type_name: str,
        name: str,
        answer: Callable[[Any, Reply], None],
        qos: Qos = SERVICES,
    ) -> Service:
        """A service whose answers may take time: `answer` gets a `Reply` to send them by.

        Raises:
            MessageError: there is no such type.
            NameInvalid: there can be no such service.
        """
        made = Service(self, type_name, name, answer, qos)
        self.participant.add((made.reader.gid,), (made.writer.gid,))
        self.attend(made)
        return made

    def client(self, type_name: str, name: str, qos: Qos = SERVICES) -> Client:
        """A client of a service.

        Raises:
            MessageError: there is no such type.
            NameInvalid: there can be no such service.
        """
        made = Client(self, type_name, name, qos)
        self.participant.add((made.reader.gid,), (made.writer.gid,))
        self.attend(made)
        return made

    def timer(self, period: float, callback: Callable[[], None]) -> Timer:
        """Call a function every `period` s.

        Raises:
            RosError: the period is not positive.
        """
        if not period > 0.0:
            raise RosError(f"a timer's period is {period} s; it must be positive")
        made = Timer(period, callback)
        self._timers.append(made)
        return made

    def attend(self, worker: Worker) -> None:
        """Call a worker whenever messages have come."""
        self._workers.append(worker)
        self._waiting.attach(worker.reader.condition)

    def drop(self, subscription: Subscription | Listener) -> None:
        """Listen no longer."""
        self._workers.remove(subscription)
        self._waiting.detach(subscription.reader.condition)
        self.participant.remove(subscription.reader.gid)
        subscription.reader.close()

    def spin_once(self, timeout: float = _LONGEST_WAIT) -> None:
        """Wait until something is to be done, at most `timeout` s, and do it."""
        now = time.monotonic()
        if any(worker.impatient for worker in self._workers):
            timeout = min(timeout, _SOON)
        wait = min([timeout, *(timer.due - now for timer in self._timers)])
        came = self._waiting.wait(int(1e9 * max(wait, 0.0)))
        for worker in tuple(self._workers):
            if came or worker.impatient:
                worker.work()
        now = time.monotonic()
        for timer in tuple(self._timers):
            if timer.cancelled:
                self._timers.remove(timer)
            elif timer.due <= now:
                timer.call(now)

    def spin(
        self, until: Callable[[], bool] = lambda: False, timeout: float = float("inf")
    ) -> bool:
        """Serve until something is true, or for some time.

        Args:
            until: asked after everything that was done.
            timeout: s.

        Returns:
            Whether it became true; False also when the node was closed meanwhile.
        """
        end = time.monotonic() + timeout
        while not until():
            left = end - time.monotonic()
            if left <= 0.0 or not self._open:
                return False
            self.spin_once(min(left, _LONGEST_WAIT))
        return True

    def close(self) -> None:
        """Leave the graph."""
        if not self._open:
            return
        self._open = False
        self._workers.clear()
        self._timers.clear()
        # Children go with their participant; those who look get to know at once.
        self.participant.leave()
