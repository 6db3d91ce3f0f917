"""A client of an observer, in a process of its own: a page that asks for frames, or a ROS 2 node.

    python benchmarks/shared/clients.py page URL      # of the viewer; "live URL" for the live page
    python benchmarks/shared/clients.py ros DOMAIN

Prints "ready" when the first data arrive. When its standard input ends it prints the rates at which
it received data, as JSON.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import select
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from urllib.parse import urlsplit, urlunsplit


@dataclass
class Arrivals:
    """Times at which data arrived, by kind of data, s."""

    times: dict[str, list[float]] = field(default_factory=dict)

    def note(self, what: str) -> None:
        """Record one arrival."""
        self.times.setdefault(what, []).append(time.perf_counter())

    def rates(self) -> dict[str, float]:
        """Return the mean rate of each kind of data, Hz."""
        return {
            what: (len(times) - 1) / (times[-1] - times[0])
            for what, times in self.times.items()
            if len(times) > 1
        }


@dataclass
class Client:
    """A client process.

    Attributes:
        pid: of the process.
        rates: mean rate of each kind of data, Hz; empty until the process has ended.
    """

    pid: int
    rates: dict[str, float] = field(default_factory=dict)


@contextlib.contextmanager
def connected_client(*arguments: str) -> Iterator[Client]:
    """Run a client at ordinary priority while the context lasts."""
    process = subprocess.Popen(
        [sys.executable, __file__, *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        if (answer := process.stdout.readline()) != "ready\n":
            raise SystemExit(f"no client could connect: {' '.join(arguments)}: {answer.strip()}")
        client = Client(process.pid)
        yield client
        process.stdin.close()
        client.rates |= json.loads(process.stdout.read())
    finally:
        process.kill()
        process.wait()


def socket_address(page: str, name: str) -> str:
    """Return the address of a page's socket, with the token that the page's address contains."""
    parts = urlsplit(page)
    return urlunsplit(parts._replace(scheme="ws", path=f"/{name}"))


async def receive_frames(address: str, arrivals: Arrivals, controls: bool) -> None:
    """Receive and acknowledge every frame, as the page does."""
    from tornado.websocket import websocket_connect

    if controls:
        controls_socket = await websocket_connect(socket_address(address, "controls"))
        drain = asyncio.ensure_future(_drain(controls_socket, arrivals))
    scene = await websocket_connect(socket_address(address, "socket"), max_message_size=1 << 28)
    while (message := await scene.read_message()) is not None:
        if isinstance(message, str) and ("paths" in message or "caption" in message):
            if "caption" in message:
                arrivals.note("frames")
            else:
                print("ready", flush=True)
            await scene.write_message("frame")
    if controls:
        await drain


async def _drain(controls_socket: object, arrivals: Arrivals) -> None:
    while (message := await controls_socket.read_message()) is not None:  # type: ignore[attr-defined]
        if "status" in message:
            arrivals.note("status")


async def page(address: str, arrivals: Arrivals, controls: bool) -> None:
    """Receive frames until standard input ends."""
    receiving = asyncio.ensure_future(receive_frames(address, arrivals, controls))
    end = asyncio.get_running_loop().run_in_executor(None, sys.stdin.read)
    await asyncio.wait((receiving, end), return_when=asyncio.FIRST_COMPLETED)
    if not receiving.cancel() and (error := receiving.exception()):
        print(f"no connection: {error}", flush=True)  # to the process that waits for "ready"


def ros(domain: int, arrivals: Arrivals) -> None:
    """Subscribe to `/joint_states` and `/tf` until standard input ends."""
    from wbc.ros import Network, Node
    from wbc.ros.qos import HIGH_RATE

    with Node("benchmark_client", network=Network(domain)) as node:
        for kind, topic in (
            ("sensor_msgs/msg/JointState", "/joint_states"),
            ("tf2_msgs/msg/TFMessage", "/tf"),
        ):
            node.create_subscription(
                kind, topic, lambda *_, topic=topic: arrivals.note(topic), HIGH_RATE
            )
        # The topics of the tick appear when the loop begins, this one with the node itself.
        if not node.spin_until(lambda: bool(node.count_subscribers("/cmd_vel")), 60.0):
            raise SystemExit("no robot's node is there")
        print("ready", flush=True)
        node.spin_until(lambda: bool(select.select([sys.stdin], [], [], 0.0)[0]))


def main() -> None:
    """Receive data, then print the rates."""
    kind, where = sys.argv[1:]
    arrivals = Arrivals()
    if kind == "ros":
        ros(int(where), arrivals)
    else:
        asyncio.run(page(where, arrivals, kind == "live"))
    print(json.dumps(arrivals.rates()), flush=True)


if __name__ == "__main__":
    main()
