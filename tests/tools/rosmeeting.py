"""Print which combinations of network settings let the nodes of two processes meet.

Side "here" has the settings of `Network`, side "there" those of a
node of ROS 2 with `rmw_cyclonedds_cpp`, each combination in a DDS domain of its own. Nodes
have met when each has received a message of the other one.
"""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
import time
from dataclasses import replace
from typing import Any

from wbc.ros import DiscoveryRange, Network, Node

TIME = 1.5  # s; nodes that can meet do so within 0.3 s
TOPICS = {"here": "from_here", "there": "from_there"}

HERE = {
    "this machine": Network(),
    "remote peer": Network(peers=("10.77.0.9",)),
    "SUBNET": Network(discovery_range=DiscoveryRange.SUBNET),
}


#: Nodes of ROS 2 Jazzy (Cyclone DDS 0.10) use the ethernet interface, where there is one, but
#: with LOCALHOST they announce themselves on the loopback interface and accept what arrives there.
THERE = {
    "LOCALHOST": Network().xml(),
    "SUBNET": (
        "<CycloneDDS><Domain><Discovery><ParticipantIndex>default</ParticipantIndex>"
        "</Discovery></Domain></CycloneDDS>"
    ),
}


def _network(side: str, here: str, there: str, domain: int) -> Network:
    if side == "there":
        system = DiscoveryRange.SYSTEM_DEFAULT
        return Network(domain, system, configuration=THERE[there])
    return replace(HERE[here], domain_id=domain)


def run(side: str) -> None:
    """Print the combinations in which one side received a message of the other one."""
    other = "there" if side == "here" else "here"
    received: set[str] = set()
    pairs: list[tuple[Node, Any]] = []
    for domain, (here, there) in enumerate(itertools.product(HERE, THERE), 1):
        node = Node(f"node_{side}", network=_network(side, here, there, domain))
        name = f"{here} | {there}"
        node.create_subscription(
            "std_msgs/msg/Empty", TOPICS[other], lambda _, name=name: received.add(name)
        )
        pairs.append((node, node.create_publisher("std_msgs/msg/Empty", TOPICS[side])))
    print("ready", flush=True)
    sys.stdin.readline()
    end = time.monotonic() + TIME
    while time.monotonic() < end:
        for node, publisher in pairs:
            publisher.publish(publisher.msg_type())
            node.spin_once(0.0)
        time.sleep(0.05)
    print(json.dumps(sorted(received)))


def main() -> None:
    pipe = subprocess.PIPE
    sides = [
        subprocess.Popen([sys.executable, __file__, side], stdin=pipe, stdout=pipe, text=True)
        for side in TOPICS
    ]
    for side in sides:
        assert side.stdout is not None
        side.stdout.readline()
    for side in sides:
        assert side.stdin is not None
        side.stdin.write("go\n")
        side.stdin.flush()
    here, there = (set(json.loads(side.communicate()[0])) for side in sides)
    print(json.dumps(sorted(here & there)))


if __name__ == "__main__":
    run(sys.argv[1]) if sys.argv[1:] else main()
