"""The node's process: it publishes the loop's ticks and sends commands to the loop.

`Bridge` starts it as `python -m wbc.ros.bridge.server`. It ends when its standard input is closed:
a parent that dies, even by SIGKILL, ends it.
"""

from __future__ import annotations

import contextlib
import sys

from wbc.errors import WbcError
from wbc.motions.engine import SWITCH_INTERVAL
from wbc.process import ParentConnection
from wbc.ros.bridge.config import NodeConfig
from wbc.ros.bridge.robot_node import RobotNode
from wbc.ros.node import Node
from wbc.ros.rosout import log_to_rosout
from wbc.runtime.stream import TickReader


def main() -> None:
    """Run the node until the parent has ended."""
    sys.setswitchinterval(SWITCH_INTERVAL)
    parent = ParentConnection()
    config: NodeConfig = parent.config
    reader = TickReader()
    with contextlib.ExitStack() as stack:
        try:
            node = Node(
                config.name,
                namespace=config.namespace,
                network=config.network,
                remappings=config.remappings,
            )
            stack.enter_context(node)
            stack.enter_context(log_to_rosout(node))
            robot_node = RobotNode(node, config, reader)
        except WbcError as error:
            parent.reply({"error": str(error)})
            return
        parent.reply({"node": node.fully_qualified_name})
        parent.listen(reader.on_message)
        node.spin_until(lambda: parent.gone)
        robot_node.stop()


if __name__ == "__main__":
    main()
