"""Services and clients, with requests and replies correlated as `rmw_cyclonedds` does it.

A request begins with the handle of the client's writer and a sequence number, and the reply
repeats both. Client and server also put an id into the USER_DATA of both their endpoints, so that
each can see whether requests and replies can both be delivered. Other middlewares correlate
requests and replies differently: services and actions work with `rmw_cyclonedds` only.
"""

from __future__ import annotations

import logging
import struct
import time
import uuid
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wbc.messages import Message, MessageError, message_type
from wbc.ros.dds_endpoints import DdsReader, DdsWriter
from wbc.ros.dds_types import dds_service_type, with_header, without_header
from wbc.ros.errors import ResponseTimeout, RosError
from wbc.ros.names import REPLY, REQUEST, dds_topic_name
from wbc.ros.qos import SERVICES, QoSProfile

if TYPE_CHECKING:
    from wbc.ros.node import Node

logger = logging.getLogger(__name__)

_REPLY_TIMEOUT = 1.0  # s that a reply waits until DDS has matched its client


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


class Service:
    """Responds to requests; created by `Node.create_service`.

    Attributes:
        service_name: fully qualified name.
        srv_type: `pkg/srv/Name`.
        response_type: class of the responses.
        invalid_count: number of requests that could not be decoded and were skipped.
        reader: DDS reader of requests.
        writer: DDS writer of replies.
    """

    def __init__(
        self,
        node: Node,
        srv_type: str,
        srv_name: str,
        callback: Callable[[Any, ServiceReply], None],
        qos_profile: QoSProfile = SERVICES,
    ) -> None:
        self.service_name, self.srv_type = node.resolve_topic_name(srv_name), srv_type
        self._request_type = message_type(f"{srv_type}_Request")
        self.response_type = message_type(f"{srv_type}_Response")
        self._callback = callback
        self.invalid_count = 0
        self._pending: list[tuple[float, ServiceReply, bytes]] = []
        self._matched_clients: set[int] = set()
        identity = f"serviceid={_identity()};"
        participant = node.participant
        self.writer = DdsWriter(
            participant,
            dds_topic_name(REPLY, self.service_name),
            dds_service_type(self.response_type.type_name),
            qos_profile,
            f"{identity}typehash={self.response_type.type_hash()};",
        )
        self.reader = DdsReader(
            participant,
            dds_topic_name(REQUEST, self.service_name),
            dds_service_type(self._request_type.type_name),
            qos_profile,
            f"{identity}typehash={self._request_type.type_hash()};",
        )

    @property
    def has_pending(self) -> bool:
        """Whether replies wait until DDS has matched their clients."""
        return bool(self._pending)

    def execute(self) -> None:
        """Send pending replies and respond to the received requests."""
        pending, self._pending = self._pending, []
        for until, reply, data in pending:
            self._send(until, reply, data)
        for data, info in self.reader.take():
            try:
                client, number, body = without_header(data)
                request = self._request_type.decode(body)
            except (MessageError, struct.error) as error:
                self.invalid_count += 1
                logger.warning("%s: skipped a request: %s", self.service_name, error)
                continue
            self._callback(request, ServiceReply(self, client, number, info.writer))

    def send_response(self, reply: ServiceReply, response: Message) -> None:
        """Send a response; see `ServiceReply.send`."""
        data = with_header(response.encode(), reply.client, reply.number)
        self._send(time.monotonic() + _REPLY_TIMEOUT, reply, data)

    def _send(self, until: float, reply: ServiceReply, data: bytes) -> None:
        matched = self._is_client_matched(reply.writer)
        if matched:
            self.writer.write(data)
        elif matched is None and time.monotonic() < until:
            self._pending.append((until, reply, data))

    def _is_client_matched(self, writer: int) -> bool | None:
        """Return whether the client receives replies; None: not yet; False: it has left."""
        if writer in self._matched_clients:
            return True
        endpoint = self.reader.matched_endpoint(writer)
        if endpoint is None:
            return False
        client = _user_value(endpoint, "clientid")
        if client and not any(
            _user_value(reader, "clientid") == client
            for handle in self.writer.matched
            if (reader := self.writer.matched_endpoint(handle)) is not None
        ):
            return None
        self._matched_clients.add(writer)
        return True

    def __repr__(self) -> str:
        return f"Service({self.srv_type} on {self.service_name})"


class Client:
    """Sends requests to a service; created by `Node.create_client`.

    Attributes:
        service_name: fully qualified name of the service.
        srv_type: `pkg/srv/Name`.
        request_type: class of the requests.
        reader: DDS reader of replies.
        writer: DDS writer of requests.
    """

    has_pending = False

    def __init__(
        self, node: Node, srv_type: str, srv_name: str, qos_profile: QoSProfile = SERVICES
    ) -> None:
        self._node = node
        self.service_name, self.srv_type = node.resolve_topic_name(srv_name), srv_type
        self.request_type = message_type(f"{srv_type}_Request")
        self._response_type = message_type(f"{srv_type}_Response")
        self._number = 0
        self._futures: dict[int, Future[Any]] = {}  # by sequence number
        identity = f"clientid={_identity()};"
        participant = node.participant
        self.reader = DdsReader(
            participant,
            dds_topic_name(REPLY, self.service_name),
            dds_service_type(self._response_type.type_name),
            qos_profile,
            f"{identity}typehash={self._response_type.type_hash()};",
        )
        self.writer = DdsWriter(
            participant,
            dds_topic_name(REQUEST, self.service_name),
            dds_service_type(self.request_type.type_name),
            qos_profile,
            f"{identity}typehash={self.request_type.type_hash()};",
        )

    def service_is_ready(self) -> bool:
        """Return whether there is a server that receives requests and whose replies arrive."""
        readers, writers = self.writer.matched, self.reader.matched
        if not readers or not writers:
            return False
        servers = {_user_value(self.writer.matched_endpoint(h), "serviceid") for h in readers}
        repliers = {_user_value(self.reader.matched_endpoint(h), "serviceid") for h in writers}
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
        if request.type_name != self.request_type.type_name:
            raise RosError(
                f"{self.service_name} takes {self.request_type.type_name}, not {request.type_name}"
            )
        data = request.encode()
        self._number += 1
        future: Future[Any] = Future()
        self._futures[self._number] = future
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
        future = self.call_async(request)
        number = self._number
        if not self._node.spin_until(future.done, max(end - time.monotonic(), 0.0)):
            self._futures.pop(number, None)
            raise ResponseTimeout(f"{self.service_name} did not respond in {timeout_sec:g} s")
        return future.result()

    def execute(self) -> None:
        """Complete the futures of the received responses."""
        for data, _ in self.reader.take():
            try:
                client, number, body = without_header(data)
                if client != self.writer.handle or number not in self._futures:
                    continue  # the request of another client
                response = self._response_type.decode(body)
            except (MessageError, struct.error) as error:
                logger.warning("%s: skipped a reply: %s", self.service_name, error)
                continue
            self._futures.pop(number).set_result(response)

    def __repr__(self) -> str:
        return f"Client({self.srv_type} on {self.service_name})"


def _identity() -> str:
    return ".".join(f"{byte:x}" for byte in uuid.uuid4().bytes)


def _user_value(endpoint: Any, key: str) -> str:
    """Return a value of `key=value;…` in an endpoint's USER_DATA; empty if the key is absent."""
    from cyclonedds.core import Policy

    if endpoint is None or Policy.Userdata not in endpoint.qos:
        return ""
    for item in endpoint.qos[Policy.Userdata].data.decode("utf-8", "replace").split(";"):
        name, _, value = item.partition("=")
        if name == key:
            return str(value)
    return ""
