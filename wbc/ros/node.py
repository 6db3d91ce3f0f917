"""`Node`: a node that a ROS 2 system sees as one of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Future
from functools import cached_property
from typing import Any

from wbc.closeable import Closeable
from wbc.messages import Message
from wbc.ros import names
from wbc.ros.dds_endpoints import EndpointConfig
from wbc.ros.dds_types import raw_dds_type
from wbc.ros.errors import RosError
from wbc.ros.executor import Executor, Timer, Waitable
from wbc.ros.graph import Graph
from wbc.ros.network import Network
from wbc.ros.parameters import NodeParameter, ParameterServer
from wbc.ros.participant import Participant
from wbc.ros.qos import DEFAULT, SERVICES, QoSProfile
from wbc.ros.services import Client, Service, ServiceReply
from wbc.ros.topics import Publisher, RawSubscription, Subscription


class Node(Closeable):
    """A ROS 2 node over DDS, with the interface of `rclpy.node.Node`.

    It is used from one thread: callbacks of subscriptions, services and timers run in `spin`.

    Example:
        >>> String = message_type("std_msgs/msg/String")
        >>> node = Node("talker")
        >>> publisher = node.create_publisher(String, "chatter", 10)
        >>> timer = node.create_timer(0.5, lambda: publisher.publish(String(data="hello")))
        >>> node.spin()

    Args:
        node_name: name of the node.
        namespace: namespace of the node, in which its relative names are resolved.
        network: DDS domain and network interface; `Network.from_environment()` by default.
        remappings: new names of topics, services and actions by their names, both absolute,
            relative or private.

    Attributes:
        name: name of the node.
        namespace: namespace, with a leading slash.
        participant: DDS participant.

    Raises:
        MissingExtra: `cyclonedds` is not installed.
        RosError: the name is invalid, or the DDS domain cannot be joined.
    """

    def __init__(
        self,
        node_name: str,
        *,
        namespace: str = "/",
        network: Network | None = None,
        remappings: Mapping[str, str] | None = None,
    ) -> None:
        self.name = names.validate_node_name(node_name)
        self.namespace = names.normalize_namespace(namespace)
        self._remappings = {
            self._absolute_name(old): self._absolute_name(new)
            for old, new in (remappings or {}).items()
        }
        self.network = network or Network.from_environment()
        self.participant = Participant(self.namespace, self.name, self.network)
        self._executor = Executor(self.participant.dds)
        self._open = True

    def __repr__(self) -> str:
        state = "" if self._open else ", closed"
        return f"Node('{self.fully_qualified_name}', {self.network}{state})"

    @property
    def fully_qualified_name(self) -> str:
        """Namespace and name."""
        return f"{self.namespace.rstrip('/')}/{self.name}"

    def resolve_topic_name(self, topic: str) -> str:
        """Return the full, remapped name of a topic or service; see `names.resolve_name`."""
        name = self._absolute_name(topic)
        return self._remappings.get(name, name)

    def _absolute_name(self, name: str) -> str:
        return names.resolve_name(name, self.name, self.namespace)

    def create_publisher(
        self, msg_type: str | type[Message], topic: str, qos_profile: QoSProfile | int = DEFAULT
    ) -> Publisher:
        """Create a publisher.

        Args:
            msg_type: message class or its name, `pkg/msg/Name`.
            topic: absolute, relative or private name of the topic.
            qos_profile: quality of service, or the history depth alone.

        Raises:
            MessageError: there is no such type.
            InvalidName: the name of the topic is invalid.
        """
        return Publisher(self, msg_type, topic, qos_profile)

    def create_subscription(
        self,
        msg_type: str | type[Message],
        topic: str,
        callback: Callable[..., object],
        qos_profile: QoSProfile | int = DEFAULT,
        ignore_local_publications: bool = False,
    ) -> Subscription:
        """Create a subscription.

        Args:
            msg_type: message class or its name, `pkg/msg/Name`.
            topic: absolute, relative or private name of the topic.
            callback: called with each message, or with each message and its `MessageInfo` if it
                takes two arguments.
            qos_profile: quality of service, or the history depth alone.
            ignore_local_publications: whether messages of this node are not received.

        Raises:
            MessageError: there is no such type.
            InvalidName: the name of the topic is invalid.
        """
        subscription = Subscription(
            self, msg_type, topic, callback, qos_profile, ignore_local_publications
        )
        self.add_waitable(subscription)
        return subscription

    def create_raw_subscription(
        self,
        dds_type_name: str,
        topic: str,
        callback: Callable[..., object],
        qos_profile: QoSProfile | int = DEFAULT,
        type_hash: str = "",
    ) -> RawSubscription:
        """Create a subscription to serialized messages, whose type need not be known here.

        Args:
            dds_type_name: for example `std_msgs::msg::dds_::String_`.
            topic: absolute, relative or private name of the topic.
            callback: called with the bytes of each message, CDR header included, or with these
                and a `MessageInfo` if it takes two arguments.
            qos_profile: quality of service, or the history depth alone.
            type_hash: hash of the type to announce, `RIHS01_…`; nodes of ROS 2 warn if there is
                none.

        Raises:
            InvalidName: the name of the topic is invalid.
        """
        name = self.resolve_topic_name(topic)
        dds_name, sample_type = names.dds_topic_name(names.TOPIC, name), raw_dds_type(dds_type_name)
        user_data = f"typehash={type_hash};" if type_hash else ""
        config = EndpointConfig(dds_name, sample_type, QoSProfile.of(qos_profile), user_data)
        subscription = RawSubscription(self, config, name, callback)
        self.add_waitable(subscription)
        return subscription

    def create_service(
        self,
        srv_type: str,
        srv_name: str,
        callback: Callable[[Any, Any], Message],
        qos_profile: QoSProfile = SERVICES,
    ) -> Service:
        """Create a service.

        Args:
            srv_type: `pkg/srv/Name`.
            srv_name: absolute, relative or private name of the service.
            callback: called with each request and an empty response; returns the response.
            qos_profile: quality of service.

        Raises:
            MessageError: there is no such type.
            InvalidName: the name of the service is invalid.
        """

        def respond(request: Any, reply: ServiceReply) -> None:
            reply.send(callback(request, service.response_type()))

        service = self.create_deferred_service(srv_type, srv_name, respond, qos_profile)
        return service

    def create_deferred_service(
        self,
        srv_type: str,
        srv_name: str,
        callback: Callable[[Any, ServiceReply], None],
        qos_profile: QoSProfile = SERVICES,
    ) -> Service:
        """Create a service that may respond later; see `create_service` for the arguments.

        The callback is called with each request and a `ServiceReply`, by which the response is
        sent.
        """
        service = Service(self, srv_type, srv_name, callback, qos_profile)
        self.add_waitable(service)
        return service

    def create_client(
        self, srv_type: str, srv_name: str, qos_profile: QoSProfile = SERVICES
    ) -> Client:
        """Create a client of a service; see `create_service` for the arguments."""
        client = Client(self, srv_type, srv_name, qos_profile)
        self.add_waitable(client)
        return client

    def create_timer(self, timer_period_sec: float, callback: Callable[[], None]) -> Timer:
        """Call a function periodically.

        Args:
            timer_period_sec: period, s.
            callback: the function.

        Raises:
            RosError: the period is not positive.
        """
        if not timer_period_sec > 0.0:
            raise RosError(f"the period of a timer is {timer_period_sec} s; it must be positive")
        timer = Timer(timer_period_sec, callback)
        self._executor.add_timer(timer)
        return timer

    @cached_property
    def _parameter_server(self) -> ParameterServer:
        return ParameterServer(self)

    def declare_parameter(
        self,
        name: str,
        value: Any,
        description: str = "",
        *,
        bounds: tuple[float, float] | None = None,
        read_only: bool = False,
        on_change: Callable[[Any], None] = lambda _: None,
    ) -> NodeParameter:
        """Declare a parameter; see `NodeParameter` for the arguments.

        The first declaration also creates the parameter services of the node.

        Raises:
            RosError: the parameter is already declared, or its value has an unsupported type or is
                out of its range.
        """
        parameter = NodeParameter(name, value, description, bounds, read_only, on_change)
        return self._parameter_server.declare(parameter)

    def get_parameter(self, name: str) -> NodeParameter:
        """Return a declared parameter.

        Raises:
            RosError: the parameter is not declared.
        """
        return self._parameter_server.get(name)

    def set_parameter(self, name: str, value: Any) -> None:
        """Set a declared parameter, as another node would by its service.

        Raises:
            RosError: the parameter is not declared, or the value is refused; the text states why.
        """
        self._parameter_server.set(name, value)

    @cached_property
    def graph(self) -> Graph:
        """The other nodes, with their topics and services; they are discovered from now on."""
        return Graph(self)

    def get_topic_names_and_types(self) -> list[tuple[str, list[str]]]:
        """Return the discovered topics of the other nodes with their types, sorted by name."""
        return [(name, topic.types) for name, topic in self.graph.snapshot().topics().items()]

    def count_publishers(self, topic_name: str) -> int:
        """Return the number of discovered publishers of a topic in the other nodes."""
        return len(self.graph.snapshot().topic(self.resolve_topic_name(topic_name)).publishers)

    def count_subscribers(self, topic_name: str) -> int:
        """Return the number of discovered subscriptions to a topic in the other nodes."""
        return len(self.graph.snapshot().topic(self.resolve_topic_name(topic_name)).subscriptions)

    def add_waitable(self, waitable: Waitable) -> None:
        """Execute a waitable while the node spins, whenever its reader has received messages."""
        self._executor.add_waitable(waitable)

    def destroy_subscription(self, subscription: RawSubscription) -> None:
        """Remove a subscription."""
        self._executor.remove_waitable(subscription)
        self.participant.destroy_reader(subscription.reader)

    def spin_once(self, timeout_sec: float = 0.1) -> None:
        """Wait for messages or a timer, at most `timeout_sec` s, and run the callbacks due."""
        self._executor.spin_once(timeout_sec)

    def spin(self, timeout_sec: float = float("inf")) -> None:
        """Run callbacks until the node is closed, or for `timeout_sec` s."""
        self.spin_until(lambda: False, timeout_sec)

    def spin_until(
        self, condition: Callable[[], object], timeout_sec: float = float("inf")
    ) -> bool:
        """Run callbacks until a condition holds.

        Args:
            condition: evaluated after every `spin_once`.
            timeout_sec: time limit, s.

        Returns:
            Whether the condition holds; False after the time limit or when the node was closed.
        """
        return self._executor.spin_until(condition, timeout_sec)

    def spin_until_future_complete(
        self, future: Future[Any], timeout_sec: float = float("inf")
    ) -> bool:
        """Run callbacks until a future, such as that of `Client.call_async`, has its result.

        Returns:
            Whether it has its result.
        """
        return self.spin_until(future.done, timeout_sec)

    def close(self) -> None:
        """Leave the graph, with all publishers, subscriptions, services and clients."""
        if not self._open:
            return
        self._open = False
        self._executor.close()
        self.participant.leave()  # DDS removes the endpoints with their participant
