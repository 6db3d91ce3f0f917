"""Services and clients, with requests and replies correlated as `rmw_cyclonedds` does it.

A request begins with the handle of the client's writer and a sequence number, and the reply
repeats both. Client and server also put an id into the USER_DATA of both their endpoints, so that
each can determine whether requests and replies can both be delivered. Other middlewares correlate
requests and replies differently: services and actions work with `rmw_cyclonedds` only.
"""

from __future__ import annotations

import logging
import struct
import time
import uuid
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wbc.messages import Message, MessageError, message_type
from wbc.ros.dds_endpoints import EndpointConfig, MessageInfo
from wbc.ros.dds_types import dds_service_type, with_header, without_header
from wbc.ros.errors import ResponseTimeout, RosError
from wbc.ros.names import REPLY, REQUEST, dds_topic_name
from wbc.ros.qos import QoSProfile

if TYPE_CHECKING:
    from wbc.ros.node import Node

logger = logging.getLogger(__name__)

_REPLY_TIMEOUT = 1.0  # s that a reply waits until DDS has matched its client
_RETRY_PERIOD = 0.005  # s
_CLIENT_ID, _SERVICE_ID = "clientid", "serviceid"  # keys of USER_DATA


class _ServiceEndpoints:
    """The writer and the reader of a service or a client, which carry the same id in USER_DATA.

    Attributes:
        service_name: fully qualified name.
        srv_type: `pkg/srv/Name`.
        request_type: class of the requests.
        response_type: class of the responses.
        writer: DDS writer.
        reader: DDS reader.
    """

    def __init__(
        self,
        node: Node,
        srv_type: str,
        srv_name: str,
        qos_profile: QoSProfile,
        id_key: str,
        writes: str,
        reads: str,
    ) -> None:
        self._node = node
        self.service_name, self.srv_type = node.resolve_topic_name(srv_name), srv_type
        self.request_type = message_type(f"{srv_type}_Request")
        self.response_type = message_type(f"{srv_type}_Response")
        identity = f"{id_key}={'.'.join(f'{byte:x}' for byte in uuid.uuid4().bytes)};"

        def config(prefix: str) -> EndpointConfig:
            kind = self.request_type if prefix == REQUEST else self.response_type
            name, sample_type = (
                dds_topic_name(prefix, self.service_name),
                dds_service_type(kind.type_name),
            )
            user_data = f"{identity}typehash={kind.type_hash()};"
            return EndpointConfig(name, sample_type, qos_profile, user_data)

        self.writer = node.participant.create_writer(config(writes))
        self.reader = node.participant.create_reader(config(reads))

    def _received(self, kind: type[Message]) -> Iterator[tuple[int, int, Any, MessageInfo]]:
        """Yield client, sequence number, message and metadata of all that has been received."""
        for data, info in self.reader.take():
            try:
                client, number, body = without_header(data)
                message = kind.decode(body)
            except (MessageError, struct.error) as error:
                logger.warning("%s: skipped a message: %s", self.service_name, error)
            else:
                yield client, number, message, info

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.srv_type} on {self.service_name})"


@dataclass(frozen=True, slots=True)
class ServiceReply:
    """Sends the response to one request, at once or later.

    Attributes:
        service: the service that received the request.
        client: handle of the client's writer, in the client's process.
        number: sequence number of the request.
        writer: handle of the client's writer, in this process.
    """

    service: Service
    client: int
    number: int
    writer: int

    def send(self, response: Message) -> None:
        """Send the response as soon as the client can receive it.

        Raises:
            MessageError: a value does not fit its field.
        """
        self.service.send_response(self, response)

    @property
    def client_alive(self) -> bool:
        """Whether the client is still in the graph."""
        return self.writer in self.service.reader.matched


class Service(_ServiceEndpoints):
    """Responds to requests; created by `Node.create_service`."""

    def __init__(
        self,
        node: Node,
        srv_type: str,
        srv_name: str,
        callback: Callable[[Any, ServiceReply], None],
        qos_profile: QoSProfile,
    ) -> None:
        self._callback = callback
        self._matched_clients: set[int] = set()
        super().__init__(node, srv_type, srv_name, qos_profile, _SERVICE_ID, REPLY, REQUEST)

    def execute(self) -> None:
        """Respond to the received requests."""
        for client, number, request, info in self._received(self.request_type):
            self._callback(request, ServiceReply(self, client, number, info.writer))

    def send_response(self, reply: ServiceReply, response: Message) -> None:
        """Send a response; see `ServiceReply.send`."""
        data = with_header(response.encode(), reply.client, reply.number)
        deadline = time.monotonic() + _REPLY_TIMEOUT

        def try_to_send() -> None:
            matched = self._is_client_matched(reply.writer)
            if matched:
                self.writer.write(data)
            if matched is not None or time.monotonic() > deadline:
                timer.cancel()

        timer = self._node.create_timer(_RETRY_PERIOD, try_to_send)
        try_to_send()

    def _is_client_matched(self, writer: int) -> bool | None:
        """Return whether the client receives replies; None: not yet; False: it has left."""
        if writer in self._matched_clients:
            return True
        user_data = self.reader.matched_user_data().get(writer)
        if user_data is None:
            return False
        client = user_data.get(_CLIENT_ID)
        readers = self.writer.matched_user_data().values()
        if client and all(reader.get(_CLIENT_ID) != client for reader in readers):
            return None
        self._matched_clients.add(writer)
        return True


class Client(_ServiceEndpoints):
    """Sends requests to a service; created by `Node.create_client`."""

    def __init__(self, node: Node, srv_type: str, srv_name: str, qos_profile: QoSProfile) -> None:
        self._number = 0
        self._futures: dict[int, Future[Any]] = {}  # by sequence number
        super().__init__(node, srv_type, srv_name, qos_profile, _CLIENT_ID, REQUEST, REPLY)

    def service_is_ready(self) -> bool:
        """Return whether there is a server that receives requests and whose replies arrive."""
        servers, repliers = (
            {user_data.get(_SERVICE_ID, "") for user_data in endpoint.matched_user_data().values()}
            for endpoint in (self.writer, self.reader)
        )
        return bool(servers & repliers)

    def wait_for_service(self, timeout_sec: float) -> bool:
        """Spin the node until the service is ready; return whether it is, after `timeout_sec` s."""
        return self._node.spin_until(self.service_is_ready, timeout_sec)

    def call_async(self, request: Message) -> Future[Any]:
        """Send a request.

        Returns:
            The future response, which arrives while the node spins.

        Raises:
            MessageError: a value does not fit its field.
            RosError: the request is of another type.
        """
        given, expected = type(request).type_name, self.request_type.type_name
        if given != expected:
            raise RosError(f"{self.service_name} takes {expected}, not {given}")
        data = request.encode()
        self._number += 1
        future = self._futures[self._number] = Future()
        self.writer.write(with_header(data, self.writer.handle, self._number))
        return future

    def call(self, request: Message, timeout_sec: float = 5.0) -> Any:
        """Send a request and spin the node until the response arrives.

        Raises:
            ResponseTimeout: there was no response in `timeout_sec` s.
            MessageError: a value does not fit its field.
        """
        end = time.monotonic() + timeout_sec
        if not self.wait_for_service(timeout_sec):
            raise ResponseTimeout(f"there is no server for {self.service_name} ({self.srv_type})")
        future, number = self.call_async(request), self._number
        if not self._node.spin_until(future.done, max(end - time.monotonic(), 0.0)):
            self._futures.pop(number, None)
            raise ResponseTimeout(f"{self.service_name} did not respond in {timeout_sec:g} s")
        return future.result()

    def execute(self) -> None:
        """Complete the futures of the received responses."""
        for client, number, response, _ in self._received(self.response_type):
            if client == self.writer.handle and number in self._futures:  # else of another client
                self._futures.pop(number).set_result(response)
