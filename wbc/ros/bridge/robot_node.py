"""The robot's node: its topics, services, parameters and actions, put together."""

from __future__ import annotations

import logging
from typing import Any

from wbc.messages import message_type
from wbc.process import LatestValue, RecordRing
from wbc.ros.bridge.clock import PlantClock
from wbc.ros.bridge.cmd_vel import CmdVel
from wbc.ros.bridge.config import NodeConfig
from wbc.ros.bridge.diagnostics import Diagnostics
from wbc.ros.bridge.joint_topics import JointTopics
from wbc.ros.bridge.layout import Layout, Sample
from wbc.ros.bridge.navigate_to_pose import NavigateToPose
from wbc.ros.bridge.play_motion import PlayMotion
from wbc.ros.bridge.simulation_services import SimulationServices
from wbc.ros.bridge.state_topics import BalanceTopics, JointStates, Odometry
from wbc.ros.bridge.transforms import Transforms
from wbc.ros.joint_publisher import MAX_RATE
from wbc.ros.node import Node
from wbc.ros.qos import LATCHED
from wbc.ros.rate_limiter import RateLimiter
from wbc.runtime.mode import Mode
from wbc.teleop import CommandClient

logger = logging.getLogger(__name__)

_LEAST_LOOKS = 200.0  # Hz, at which new ticks are looked for
_LEAST_TICKS = 50.0  # Hz, for walking to a pose
_POLL_PERIOD = 0.02  # s between two looks for acknowledgements and plans


class RobotNode:
    """The topics, services, parameters and actions of a robot.

    Args:
        node: the node that has them.
        config: of the node's process.
        ring: ticks of the loop.
    """

    def __init__(self, node: Node, config: NodeConfig, ring: RecordRing) -> None:
        self._ring, self._layout = ring, Layout.of(config.robot)
        self._client = CommandClient(config.robot, config.channel, "ros")
        self._client.start_planning()
        self._needed_rate = LatestValue(1, config.rate)
        self._node = node
        rate = node.declare_parameter(
            "update_rate",
            float(config.update_rate),
            "of joint_states, Hz",
            minimum=1.0,
            maximum=MAX_RATE,
        )
        others = node.declare_parameter(
            "state_rate",
            50.0,
            "of tf, odom, wrenches, com, dcm and zmp, Hz",
            minimum=1.0,
            maximum=MAX_RATE,
        )
        self._rate, self._others = rate, others
        # What can be reset is a simulation.
        self._clock = (
            PlantClock(node, config.use_sim_time) if self._client.capabilities.can_reset else None
        )
        self._joint_states = JointStates(node, config.robot)
        self._due = RateLimiter(rate.value, 0.5 * config.dt)
        self._at_state_rate = (
            Odometry(node, config.robot),
            BalanceTopics(node, config.robot),
            Transforms(node, config.robot),
        )
        self._state_due = RateLimiter(others.value, 0.5 * config.dt)
        self._diagnostics = Diagnostics(node, config)
        text = message_type("std_msgs/msg/String")
        description = node.create_publisher(text.type_name, "robot_description", LATCHED)
        description.publish(text(data=config.robot.urdf_path.read_text("utf-8", "replace")))
        client, robot = self._client, config.robot
        cmd_vel = CmdVel(node, client)
        self._joint_topics = JointTopics(node, client)
        self._simulation = SimulationServices(node, client, robot)
        self._navigate = NavigateToPose(node, cmd_vel, robot)
        self._play = PlayMotion(node, client, cmd_vel, self._navigate)
        node.create_timer(_POLL_PERIOD, self._poll)
        self._latest: Sample | None = None
        self._looks = node.create_timer(1.0 / _LEAST_LOOKS, self._look)
        self._change_rates(None)
        for parameter in (rate, others):
            parameter.on_change = self._change_rates

    def _change_rates(self, _: Any) -> None:
        # Both at once: where the rates are the same, the stamps are, as ExactTime filters need it.
        self._due.restart(self._rate.value)
        self._state_due.restart(self._others.value)
        fastest = float(max(self._rate.value, self._others.value))
        self._looks.period = 1.0 / max(2.0 * fastest, _LEAST_LOOKS)
        self._needed_rate.write((max(fastest, _LEAST_TICKS),))

    def _poll(self) -> None:
        """Pass on what became of commands, and send the motion that has been planned."""
        for acknowledgement in self._client.poll():
            self._simulation.on_acknowledgement(acknowledgement)
            self._play.on_acknowledgement(acknowledgement)

    def _look(self) -> None:
        """Take in new ticks."""
        for record in self._ring.read():
            self._take(Sample.of(self._layout, record))

    def _take(self, sample: Sample) -> None:
        if self._clock is not None:
            sample = self._clock.stamped(sample)
        if self._latest is not None:
            self._note_changes(self._latest, sample)
        self._latest = sample
        self._diagnostics.take(sample)
        self._play.take(sample)
        if self._due.is_due(sample.stamp):
            self._joint_states.publish(sample)
        if self._state_due.is_due(sample.stamp):
            for topics in self._at_state_rate:
                topics.publish(sample)
        self._navigate.take(sample)

    def _note_changes(self, before: Sample, now: Sample) -> None:
        if now.run != before.run:
            logger.info("the robot was reset")
            self._joint_topics.end_trajectory()
        elif now.mode is Mode.FALLEN and before.mode is not Mode.FALLEN:
            logger.error("the robot fell")

    def stop(self) -> None:
        """The loop ends."""
        for action in (self._navigate, self._play):
            action.abort("the robot's loop has ended")
