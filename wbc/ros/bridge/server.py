"""The node's own process: shows the loop's ticks to ROS 2, and posts its orders.

Started by `Bridge` as `python -m wbc.ros.bridge.server`. It ends when its standard input does: a
parent that dies, however it dies, takes it along.
"""

from __future__ import annotations

import os
import threading

from wbc.errors import WbcError
from wbc.process import parent
from wbc.ros.bridge.layout import Layout
from wbc.ros.bridge.mailbox import Mailbox
from wbc.ros.bridge.order import Order
from wbc.ros.bridge.ring import StateRing
from wbc.ros.bridge.robot_node import RobotNode
from wbc.ros.node import Node


def main() -> None:
    """Serve until the parent is gone."""
    order: Order = parent.begin()
    layout = Layout.of(order.robot)
    ring = StateRing(layout.size, order.ring)
    mailbox = Mailbox(order.robot.na, order.mailbox)
    try:
        node = Node(order.name, namespace=order.space, network=order.network)
        robot_node = RobotNode(node, order, ring, mailbox)
    except WbcError as error:
        parent.answer({"error": str(error)})
        return
    parent.answer({"node": node.full_name})
    over = threading.Event()
    threading.Thread(target=_wait_for_end, args=(over,), daemon=True).start()
    with node:
        node.spin(lambda: over.is_set() or os.getppid() != order.parent)
        robot_node.stop()


def _wait_for_end(over: threading.Event) -> None:
    while parent.hear() is not None:
        pass
    over.set()


if __name__ == "__main__":
    main()
