"""The node's own process: shows the loop's ticks to ROS 2, and posts its orders.

Started by `Bridge` as `python -m wbc.ros.bridge.server`. It ends when its standard input does: a
parent that dies, however it dies, takes it along.
"""

from __future__ import annotations

import contextlib
import sys

from wbc.errors import WbcError
from wbc.motions.engine.planning import SWITCH_INTERVAL
from wbc.process import RecordRing, parent
from wbc.ros.bridge.layout import Layout
from wbc.ros.bridge.mailbox import Mailbox
from wbc.ros.bridge.order import Order
from wbc.ros.bridge.robot_node import RobotNode
from wbc.ros.node import Node
from wbc.ros.rosout import log_to_rosout


def main() -> None:
    """Serve until the parent is gone."""
    sys.setswitchinterval(SWITCH_INTERVAL)
    order: Order = parent.receive_config()
    layout = Layout.of(order.robot)
    ring = RecordRing(layout.size, order.ring)
    mailbox = Mailbox(order.robot.na, order.mailbox)
    with contextlib.ExitStack() as stack:
        try:
            node = Node(order.name, namespace=order.space, network=order.network)
            stack.enter_context(node)
            stack.enter_context(log_to_rosout(node))
            robot_node = RobotNode(node, order, ring, mailbox)
        except WbcError as error:
            parent.reply({"error": str(error)})
            return
        parent.reply({"node": node.fully_qualified_name})
        parent_monitor = parent.ParentMonitor(order.parent)
        node.spin_until(lambda: parent_monitor.gone)
        robot_node.stop()


if __name__ == "__main__":
    main()
