"""Who looks on, as a process of its own: a page that answers every frame, or a ROS 2 node.

    python benchmarks/audience.py page URL      # of the viewer; the live page's is "live URL"
    python benchmarks/audience.py ros DOMAIN

Says "ready" when it gets something to see, and in the end, when its input ends, what it saw.
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


@dataclass
class Seen:
    """What came, by the times of arrival, s."""

    times: dict[str, list[float]] = field(default_factory=dict)

    def note(self, what: str) -> None:
        """One more."""
        self.times.setdefault(what, []).append(time.perf_counter())

    def rates(self) -> dict[str, float]:
        """Of what came, Hz."""
        return {
            what: (len(times) - 1) / (times[-1] - times[0])
            for what, times in self.times.items()
            if len(times) > 1
        }


@dataclass
class Looking:
    """Somebody who looks on.

    Attributes:
        pid: of the process.
        rates: that it saw, Hz; filled in the end.
    """

    pid: int
    rates: dict[str, float] = field(default_factory=dict)


@contextlib.contextmanager
def audience(*arguments: str) -> Iterator[Looking]:
    """Somebody who looks on at ordinary priority."""
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
        if process.stdout.readline() != "ready\n":
            raise SystemExit(f"nobody looks on: {' '.join(arguments)}")
        looking = Looking(process.pid)
        yield looking
        process.stdin.close()
        looking.rates |= json.loads(process.stdout.read())
    finally:
        process.kill()
        process.wait()


async def look(address: str, seen: Seen, controls: bool) -> None:
    """Take every frame, as the page does."""
    from tornado.websocket import websocket_connect

    base = address.replace("http", "ws").replace("static/", "")
    if controls:
        desk = await websocket_connect(base + "controls")
        drain = asyncio.ensure_future(_drain(desk, seen))
    scene = await websocket_connect(base + "socket", max_message_size=1 << 28)
    while (message := await scene.read_message()) is not None:
        if isinstance(message, str) and ("paths" in message or "words" in message):
            if "words" in message:
                seen.note("frames")
            else:
                print("ready", flush=True)
            await scene.write_message("frame")
    if controls:
        await drain


async def _drain(desk: object, seen: Seen) -> None:
    while (message := await desk.read_message()) is not None:  # type: ignore[attr-defined]
        if "gauges" in message:
            seen.note("gauges")


async def page(address: str, seen: Seen, controls: bool) -> None:
    """Look on until the input ends."""
    looking = asyncio.ensure_future(look(address, seen, controls))
    await asyncio.get_running_loop().run_in_executor(None, sys.stdin.read)
    looking.cancel()


def ros(domain: int, seen: Seen) -> None:
    """Listen to `/joint_states` and `/tf` until the input ends."""
    from wbc.ros import Network, Node
    from wbc.ros.qos import HIGH_RATE, TF

    with Node("audience", network=Network(domain)) as node:
        heard = [
            node.create_subscription(kind, topic, lambda *_, topic=topic: seen.note(topic), qos)
            for kind, topic, qos in (
                ("sensor_msgs/msg/JointState", "/joint_states", HIGH_RATE),
                ("tf2_msgs/msg/TFMessage", "/tf", TF),
            )
        ]
        node.spin_until(lambda: all(one.get_publisher_count() for one in heard))
        print("ready", flush=True)
        node.spin_until(lambda: bool(select.select([sys.stdin], [], [], 0.0)[0]))


def main() -> None:
    """Look on, and tell."""
    kind, where = sys.argv[1:]
    seen = Seen()
    if kind == "ros":
        ros(int(where), seen)
    else:
        asyncio.run(page(where, seen, kind == "live"))
    print(json.dumps(seen.rates()), flush=True)


if __name__ == "__main__":
    main()
