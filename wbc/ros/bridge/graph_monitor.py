"""Warnings about the graph: another node of the same name, or no other node at all."""

from __future__ import annotations

import logging

from wbc.ros.node import Node

logger = logging.getLogger(__name__)

_PERIOD = 1.0  # s
_ALONE = 10.0  # s without having met any node after which a hint is given


class GraphMonitor:
    """Looks at the names of the other nodes once per second.

    Args:
        node: the node whose name should be its own.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._others_of_name = 0
        self._looks_alone = 0  # before the first other node was met
        self._has_met = False
        node.create_timer(_PERIOD, self._look)

    def _look(self) -> None:
        names = self._node.graph.node_names()
        others = names.count(self._node.fully_qualified_name)
        if others > self._others_of_name:
            logger.warning(
                "another node of this domain is named %s, too: commands reach both. Choose another "
                "--name, --namespace or ROS_DOMAIN_ID",
                self._node.fully_qualified_name,
            )
        self._others_of_name = others
        self._has_met = self._has_met or bool(names)
        if not self._has_met:
            self._looks_alone += 1
            if self._looks_alone == round(_ALONE / _PERIOD):
                logger.warning("no other node has been met (%s)", self._node.network.hint)
