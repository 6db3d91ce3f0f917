"""Services: questions and answers, correlated as `rmw_cyclonedds` does it.

Before its own fields a request carries the handle of the client's writer and a number, and the
reply repeats both. Client and server also put an id into the USER_DATA of both their endpoints, so
that each can see whether both ways are open. Other middlewares correlate in other ways: services
and actions work with `rmw_cyclonedds` alone.
"""

from __future__ import annotations

import logging
import struct
import time
import uuid
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wbc.messages import Message, MessageError, message_type
from wbc.ros.endpoints import Reader, Writer
from wbc.ros.errors import NoAnswer, RosError
from wbc.ros.names import REPLY, REQUEST, dds_topic
from wbc.ros.qos import SERVICES, Qos
from wbc.ros.wire import dds_service_type, with_header, without_header

if TYPE_CHECKING:
    from wbc.ros.node import Node

logger = logging.getLogger(__name__)

_PATIENCE = 1.0  # s that a reply waits for its client to listen


@dataclass(frozen=True, slots=True)
class Reply:
    """To one request; it may be sent at once or later.

    Attributes:
        service: that was asked.
        client: handle of the client's writer, in the client's process.
        number: of the question.
        writer: handle of the client's writer, in this process.
    """

    service: Service
    client: int
    number: int
    writer: int

    def send(self, response: Message) -> None:
        """Send it, as soon as the client listens.

        Raises:
            MessageError: a value does not fit its field.
        """
        self.service.reply(self, response)

    @property
    def client_alive(self) -> bool:
        """Whether whoever asked is still there."""
        return self.writer in self.service.reader.matched


class Service:
    """Answers requests; `Node.service` makes it.

    Attributes:
        name: its full ROS name.
        type_name: `pkg/srv/Name`.
        bad: requests that could not be read and were skipped.
        reader: of requests.
        writer: of replies.
    """

    def __init__(
        self,
        node: Node,
        type_name: str,
        name: str,
        answer: Callable[[Any, Reply], None],
        qos: Qos = SERVICES,
    ) -> None:
        self.name, self.type_name = node.resolve(name), type_name
        self._request = message_type(f"{type_name}_Request")
        self._response = message_type(f"{type_name}_Response")
        self._answer = answer
        self.bad = 0
        self._late: list[tuple[float, Reply, bytes]] = []
        self._listening: set[int] = set()
        identity = f"serviceid={_identity()};"
        participant = node.participant
        self.writer = Writer(
            participant,
            dds_topic(REPLY, self.name),
            dds_service_type(self._response.type_name),
            qos,
            f"{identity}typehash={self._response.type_hash()};",
        )
        self.reader = Reader(
            participant,
            dds_topic(REQUEST, self.name),
            dds_service_type(self._request.type_name),
            qos,
            f"{identity}typehash={self._request.type_hash()};",
        )

    @property
    def impatient(self) -> bool:
        """Whether replies wait for their clients."""
        return bool(self._late)

    def work(self) -> None:
        """Answer what has been asked."""
        late, self._late = self._late, []
        for until, reply, data in late:
            self._send(until, reply, data)
        for data, info in self.reader.take():
            try:
                client, number, body = without_header(data)
                request = self._request.decode(body)
            except (MessageError, struct.error) as error:
                self.bad += 1
                logger.warning("%s: a request was skipped: %s", self.name, error)
                continue
            self._answer(request, Reply(self, client, number, info.writer))

    def reply(self, reply: Reply, response: Message) -> None:
        """See `Reply.send`."""
        data = with_header(response.encode(), reply.client, reply.number)
        self._send(time.monotonic() + _PATIENCE, reply, data)

    def _send(self, until: float, reply: Reply, data: bytes) -> None:
        listens = self._client_listens(reply.writer)
        if listens:
            self.writer.write(data)
        elif listens is None and time.monotonic() < until:
            self._late.append((until, reply, data))

    def _client_listens(self, writer: int) -> bool | None:
        """Whether the client gets replies already; None: not yet; False: it has gone."""
        if writer in self._listening:
            return True
        peer = self.reader.peer(writer)
        if peer is None:
            return False
        client = _user_value(peer, "clientid")
        if client and not any(
            _user_value(reader, "clientid") == client
            for handle in self.writer.matched
            if (reader := self.writer.peer(handle)) is not None
        ):
            return None
        self._listening.add(writer)
        return True


class Client:
    """Asks a service; `Node.client` makes it.

    Attributes:
        name: the service's full ROS name.
        type_name: `pkg/srv/Name`.
        request_type: class of its requests.
        reader: of replies.
        writer: of requests.
    """

    impatient = False

    def __init__(self, node: Node, type_name: str, name: str, qos: Qos = SERVICES) -> None:
        self._node = node
        self.name, self.type_name = node.resolve(name), type_name
        self.request_type = message_type(f"{type_name}_Request")
        self._response = message_type(f"{type_name}_Response")
        self._number = 0
        self._open: dict[int, Callable[[Any], None]] = {}
        identity = f"clientid={_identity()};"
        participant = node.participant
        self.reader = Reader(
            participant,
            dds_topic(REPLY, self.name),
            dds_service_type(self._response.type_name),
            qos,
            f"{identity}typehash={self._response.type_hash()};",
        )
        self.writer = Writer(
            participant,
            dds_topic(REQUEST, self.name),
            dds_service_type(self.request_type.type_name),
            qos,
            f"{identity}typehash={self.request_type.type_hash()};",
        )

    @property
    def available(self) -> bool:
        """Whether somebody serves it, and both ways are open."""
        readers, writers = self.writer.matched, self.reader.matched
        if not readers or not writers:
            return False
        asked = {_user_value(self.writer.peer(handle), "serviceid") for handle in readers}
        answering = {_user_value(self.reader.peer(handle), "serviceid") for handle in writers}
        return bool(asked & answering)

    def wait(self, timeout: float) -> bool:
        """Wait until it is available; whether it became so in `timeout` s."""
        return self._node.spin(lambda: self.available, timeout)

    def send(self, request: Message, answered: Callable[[Any], None]) -> None:
        """Ask, and go on; `answered` is called with the response while the node spins.

        Raises:
            MessageError: a value does not fit its field.
            RosError: the request is another service's.
        """
        if request.type_name != self.request_type.type_name:
            raise RosError(
                f"{self.name} takes {self.request_type.type_name}, not {request.type_name}"
            )
        self._number += 1
        self._open[self._number] = answered
        self.writer.write(with_header(request.encode(), self.writer.handle, self._number))

    def call(self, request: Message, timeout: float = 5.0) -> Any:
        """Ask, and wait for the response.

        Raises:
            NoAnswer: there was none in `timeout` s.
            MessageError: a value does not fit its field.
        """
        end = time.monotonic() + timeout
        if not self.wait(timeout):
            raise NoAnswer(f"nobody serves {self.name} ({self.type_name})")
        answers: list[Any] = []
        self.send(request, answers.append)
        number = self._number
        if not self._node.spin(lambda: bool(answers), max(end - time.monotonic(), 0.0)):
            self._open.pop(number, None)
            raise NoAnswer(f"{self.name} did not answer in {timeout:g} s")
        return answers[0]

    def work(self) -> None:
        """Hand over the responses that have come."""
        for data, _ in self.reader.take():
            try:
                client, number, body = without_header(data)
                if client != self.writer.handle or number not in self._open:
                    continue  # another client's
                response = self._response.decode(body)
            except (MessageError, struct.error) as error:
                logger.warning("%s: a reply was skipped: %s", self.name, error)
                continue
            self._open.pop(number)(response)


def _identity() -> str:
    return ".".join(f"{byte:x}" for byte in uuid.uuid4().bytes)


def _user_value(peer: Any, key: str) -> str:
    """A value from `key=value;…` in an endpoint's USER_DATA; empty if it is not there."""
    from cyclonedds.core import Policy

    if peer is None or Policy.Userdata not in peer.qos:
        return ""
    for item in peer.qos[Policy.Userdata].data.decode("utf-8", "replace").split(";"):
        name, _, value = item.partition("=")
        if name == key:
            return str(value)
    return ""
