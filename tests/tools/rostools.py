"""Helpers for the tests of ROS 2: unused domains, peer processes, subscriptions, messages."""

from __future__ import annotations

import itertools
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from wbc.messages import message_type
from wbc.messages.typestore import number_dtype, typestore
from wbc.ros import Network, Node

ROOT = Path(__file__).resolve().parents[2]
TIMEOUT = 20.0  # s, because the machine may be busy
# Domains below 102 do not use the range of ephemeral ports.
_domains = itertools.count(os.getpid() * 13)
_reservations: list[socket.socket] = []


def unused_domain() -> int:
    """Return a domain that no other test run uses; a bound TCP port reserves it."""
    for number in itertools.islice(_domains, 100):
        domain = 1 + number % 100
        reservation = socket.socket()  # TCP, whereas DDS uses UDP
        try:
            reservation.bind(("127.0.0.1", 7400 + 250 * domain))
        except OSError:
            reservation.close()
        else:
            _reservations.append(reservation)
            return domain
    raise AssertionError("all hundred domains are in use")


def environment(domain: int) -> dict[str, str]:
    """Return the environment of a process that discovers peers on the loopback interface only."""
    variables = {
        key: value
        for key, value in os.environ.items()
        if not key.startswith("ROS_") and key != "CYCLONEDDS_URI"
    }
    paths = os.pathsep.join((str(ROOT), str(ROOT / "tests" / "tools")))
    return {**variables, "PYTHONPATH": paths, "ROS_DOMAIN_ID": str(domain)}


def restore_sigint() -> None:
    """Restore SIGINT in a child process, which background test runs ignore."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


class PeerProcess:
    """Another process in the same domain, which has reported that it is ready."""

    def __init__(self, domain: int, *command: str, configuration: str = "") -> None:
        self.process = subprocess.Popen(
            [sys.executable, *command],
            env={**environment(domain), "PEER_CONFIGURATION": configuration},
            preexec_fn=restore_sigint,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.first_line = self.read_line()
        if not self.first_line:
            self.process.kill()
            raise AssertionError(f"{command} did not start: {self.process.communicate()[1]}")

    @classmethod
    def start_peer(
        cls, domain: int, kind: str, *arguments: str, configuration: str = ""
    ) -> PeerProcess:
        """Start a peer of `rospeer.py`, optionally with a configuration of Cyclone DDS."""
        script = str(ROOT / "tests" / "tools" / "rospeer.py")
        return cls(domain, script, kind, str(domain), *arguments, configuration=configuration)

    @classmethod
    def start_wbc(cls, domain: int, *arguments: str) -> PeerProcess:
        """Start the `wbc` command."""
        return cls(domain, "-m", "wbc", *arguments)

    def read_line(self) -> str:
        """Return the next output line; empty if the process has ended or a timeout has passed."""
        assert self.process.stdout is not None
        end = threading.Timer(3 * TIMEOUT, self.process.kill)
        end.start()
        try:
            return self.process.stdout.readline().strip()
        finally:
            end.cancel()

    def write_line(self, line: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(f"{line}\n")
        self.process.stdin.flush()

    def kill(self) -> None:
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    def __enter__(self) -> PeerProcess:
        return self

    def __exit__(self, *_: object) -> None:
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            try:
                self.process.communicate(timeout=10.0)
            except subprocess.TimeoutExpired:
                self.kill()
        for stream in (self.process.stdin, self.process.stdout, self.process.stderr):
            if stream is not None:
                stream.close()


def start_example(domain: int, script: str, *arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, str(ROOT / "examples" / "ros2" / script), *arguments],
        env=environment(domain),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


class MessageCollector:
    """Collects the messages of one topic."""

    def __init__(self, node: Node, kind: str, topic: str, *args: Any) -> None:
        self.node = node
        self.messages: list[Any] = []
        self.infos: list[Any] = []
        self.subscription = node.create_subscription(kind, topic, self._on_message, *args)

    def _on_message(self, message: Any, info: Any) -> None:
        self.messages.append(message)
        self.infos.append(info)

    def close(self) -> None:
        self.node.destroy_subscription(self.subscription)

    @property
    def last(self) -> Any:
        return self.messages[-1]

    def __len__(self) -> int:
        return len(self.messages)

    def clear(self) -> None:
        self.messages.clear()
        self.infos.clear()

    def wait(
        self, condition: Callable[[Any], bool] = lambda _: True, timeout: float = TIMEOUT
    ) -> Any:
        """Wait for the first new message that satisfies a condition; return it."""
        self.clear()
        return self.find(condition, timeout)

    def find(self, condition: Callable[[Any], bool], timeout: float = TIMEOUT) -> Any:
        """Return the first message, received or new, that satisfies a condition."""
        found: list[Any] = []
        checked = 0

        def is_found() -> bool:
            nonlocal checked
            found.extend(m for m in self.messages[checked:] if condition(m))
            checked = len(self.messages)
            return bool(found)

        assert self.node.spin_until(is_found, timeout), (
            f"no such message on {self.subscription.topic_name}"
        )
        return found[0]


def node(name: str, domain: int) -> Node:
    return Node(name, network=Network(domain))


def configuration(path: str, value: str) -> str:
    """Return a configuration of Cyclone DDS with one setting below `Domain`."""
    for name in reversed(("CycloneDDS", "Domain", *path.split("/"))):
        value = f"<{name}>{value}</{name}>"
    return value


#: A silent participant counts as dead after this lease duration.
SHORT_LEASE = configuration("Discovery/LeaseDuration", "3 s")


def random_message(name: str, seed: int) -> Any:
    """Return a message with a random value in every field."""
    from rosbags.interfaces import Nodetype

    rng = np.random.default_rng(seed)

    def value(desc: Any) -> Any:
        match desc:
            case Nodetype.NAME, name:
                return random_message(name, int(rng.integers(1 << 30)))
            case Nodetype.BASE, ("string", _):
                return "".join(rng.choice(list("abc äß€\n'"), rng.integers(0, 8)))
            case Nodetype.BASE, (primitive, _):
                dtype = number_dtype(primitive)
                if dtype.kind == "f":
                    return dtype.type(rng.normal()).item()
                if dtype.kind == "b":
                    return bool(rng.integers(2))
                limits = np.iinfo(dtype)
                return int(rng.integers(limits.min, limits.max, dtype=dtype, endpoint=True))
            case Nodetype.ARRAY, (element, size):
                return [value(element) for _ in range(size)]
            case Nodetype.SEQUENCE, (element, size):
                return [value(element) for _ in range(rng.integers(1, min(size or 3, 3) + 1))]
        raise AssertionError(desc)

    return message_type(name)(**{f: value(d) for f, d in typestore().fielddefs[name][1]})


def used_types() -> list[str]:
    """Return all types of the packages whose messages the library uses."""
    packages = {
        *(
            "action_msgs",
            "builtin_interfaces",
            "control_msgs",
            "diagnostic_msgs",
            "geometry_msgs",
            "nav2_msgs",
        ),
        *("nav_msgs", "play_motion2_msgs", "rcl_interfaces", "rmw_dds_common", "rosgraph_msgs"),
        *("sensor_msgs", "std_msgs", "std_srvs", "tf2_msgs", "trajectory_msgs", "wbc_msgs"),
    }
    return sorted(name for name in typestore().fielddefs if name.split("/")[0] in packages)
