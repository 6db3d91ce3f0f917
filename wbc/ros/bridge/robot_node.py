"""The robot's node: its topics, services, parameters and actions, put together."""

from __future__ import annotations

import logging
from typing import Any

from wbc.ros.bridge.clock import PlantClock
from wbc.ros.bridge.cmd_vel import CmdVel
from wbc.ros.bridge.config import NodeConfig
from wbc.ros.bridge.diagnostics import Diagnostics
from wbc.ros.bridge.joint_topics import JointTopics
from wbc.ros.bridge.navigate_to_pose import NavigateToPose
from wbc.ros.bridge.node_topics import TOPICS, NodeTopics
from wbc.ros.bridge.play_motion import PlayMotion
from wbc.ros.bridge.simulation_services import SimulationServices
from wbc.ros.bridge.stamped_tick import StampedTick
from wbc.ros.bridge.tick_topics import TickTopics
from wbc.ros.joint_publisher import MAX_RATE
from wbc.ros.node import Node
from wbc.runtime.mode import Mode
from wbc.runtime.stream import TickReader
from wbc.teleop import CommandClient

logger = logging.getLogger(__name__)

_LEAST_LOOKS = 200.0  # Hz, at which new ticks are looked for
_MAX_TICKS = 4096  # taken at once
_POLL_PERIOD = 0.02  # s between two looks for acknowledgements and plans


class RobotNode:
    """The topics, services, parameters and actions of a robot.

    Args:
        node: the node that has them.
        config: of the node's process.
        reader: of the loop's ticks.
    """

    def __init__(self, node: Node, config: NodeConfig, reader: TickReader) -> None:
        self._reader = reader
        self._client = CommandClient(config.robot, config.channel, "ros")
        self._client.start_planning()
        self._node = node
        self._update_rate = node.declare_parameter(
            "update_rate",
            float(config.update_rate),
            "rate of joint_states, Hz",
            minimum=1.0,
            maximum=MAX_RATE,
        )
        self._state_rate = node.declare_parameter(
            "state_rate",
            50.0,
            "rate of all other topics of the tick, such as tf, odom and balance/com, Hz",
            minimum=1.0,
            maximum=MAX_RATE,
        )
        # What can be reset is a simulation.
        self._clock = (
            PlantClock(node, config.use_sim_time) if self._client.capabilities.can_reset else None
        )
        rates = (self._update_rate.value, self._state_rate.value)
        self._topics = TickTopics(node, config.robot, *rates, 0.5 * config.dt)
        self._diagnostics = Diagnostics(node, config)
        client, robot = self._client, config.robot
        cmd_vel = CmdVel(node, client)
        self._joint_topics = JointTopics(node, client)
        self._simulation = SimulationServices(node, client, robot)
        self._navigate = NavigateToPose(node, cmd_vel, robot)
        self._play = PlayMotion(node, client, cmd_vel, self._navigate)
        node.create_timer(_POLL_PERIOD, self._poll)
        self._latest: StampedTick | None = None
        NodeTopics(node, robot, (*TOPICS, *config.topics), lambda: self._latest)
        self._looks = node.create_timer(1.0 / _LEAST_LOOKS, self._look)
        self._change_rates(None)
        for parameter in (self._update_rate, self._state_rate):
            parameter.on_change = self._change_rates

    def _change_rates(self, _: Any) -> None:
        rates = (float(self._update_rate.value), float(self._state_rate.value))
        self._topics.change_rates(*rates)
        self._looks.period = 1.0 / max(2.0 * max(rates), _LEAST_LOOKS)

    def _poll(self) -> None:
        """Pass on what became of commands, and send the motion that has been planned."""
        for acknowledgement in self._client.poll():
            self._simulation.on_acknowledgement(acknowledgement)
            self._play.on_acknowledgement(acknowledgement)

    def _look(self) -> None:
        """Take in new ticks."""
        records = self._reader.take(_MAX_TICKS)
        self._topics.attach(self._reader.schema)
        for k in range(len(records)):
            self._take(StampedTick.of(records[k : k + 1]))

    def _take(self, tick: StampedTick) -> None:
        if self._clock is not None:
            tick = self._clock.stamp(tick)
        if self._latest is not None:
            self._log_changes(self._latest, tick)
        self._latest = tick
        self._diagnostics.take(tick)
        self._play.take(tick)
        self._topics.publish(tick)
        self._navigate.take(tick)

    def _log_changes(self, before: StampedTick, now: StampedTick) -> None:
        if now.run != before.run:
            logger.info("the robot was reset")
            self._joint_topics.end_trajectory()
        elif now.mode is Mode.FALLEN and before.mode is not Mode.FALLEN:
            logger.error("the robot fell")

    def stop(self) -> None:
        """The loop ends."""
        for action in (self._navigate, self._play):
            action.abort("the robot's loop has ended")
