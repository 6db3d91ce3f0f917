"""The topics, services, parameters and actions of the robot's node."""

from __future__ import annotations

import logging
import time

from wbc.ros.bridge.catch_up import CatchUpPace
from wbc.ros.bridge.clock import PlantClock
from wbc.ros.bridge.cmd_vel import CmdVel
from wbc.ros.bridge.config import NodeConfig
from wbc.ros.bridge.diagnostics import Diagnostics
from wbc.ros.bridge.follow_joint_trajectory import FollowJointTrajectory
from wbc.ros.bridge.goal_pose import GoalPose
from wbc.ros.bridge.graph_monitor import GraphMonitor
from wbc.ros.bridge.joint_topics import JointTopics
from wbc.ros.bridge.navigate_to_pose import NavigateToPose
from wbc.ros.bridge.node_topics import TOPICS, NodeTopics
from wbc.ros.bridge.play_motion import PlayMotion
from wbc.ros.bridge.simulation_services import SimulationServices
from wbc.ros.bridge.stamped_tick import StampedTick
from wbc.ros.bridge.tick_topics import TickTopics
from wbc.ros.bridge.tunable_parameters import TunableParameters
from wbc.ros.node import Node
from wbc.ros.type_descriptions import serve_type_descriptions
from wbc.runtime.mode import Mode
from wbc.runtime.stream import TickReader
from wbc.teleop import CommandClient

logger = logging.getLogger(__name__)

_POLL_PERIOD = 0.02  # s between two polls of the command channel


class RobotNode:
    """The topics, services, parameters and actions of a robot.

    Args:
        node: node that gets them.
        config: configuration of the node's process.
        reader: reads the loop's ticks.
    """

    def __init__(self, node: Node, config: NodeConfig, reader: TickReader) -> None:
        robot = config.robot
        self._reader, self._pace = reader, CatchUpPace(config.dt)
        self._latest: StampedTick | None = None
        self._client = client = CommandClient(robot, config.channel, "ros")
        client.start_planning()
        # A robot that can be reset is simulated.
        self._clock = (
            PlantClock(node, config.use_sim_time) if client.capabilities.can_reset else None
        )
        self._topics = TickTopics(node, config)
        self._diagnostics = Diagnostics(node, config)
        self._joint_topics = JointTopics(node, client, robot)
        self._simulation = SimulationServices(node, client, robot)
        cmd_vel = CmdVel(node, client)
        self._navigate = NavigateToPose(node, cmd_vel, robot)
        self._play = PlayMotion(node, client, cmd_vel, self._navigate)
        GoalPose(node)
        self._follow = FollowJointTrajectory(node, self._joint_topics, robot)
        TunableParameters(node, client)
        GraphMonitor(node)
        serve_type_descriptions(node)
        NodeTopics(node, robot, (*TOPICS, *config.topics), lambda: self._latest)
        for name, value in config.parameters.items():
            node.set_parameter(name, value)
        node.create_timer(_POLL_PERIOD, self._poll_commands)
        self._read_timer = node.create_timer(self._pace.period(0.0), self._read_ticks)

    def _poll_commands(self) -> None:
        """Send the motion that has been planned, and process the loop's acknowledgements."""
        for acknowledgement in self._client.poll():
            self._simulation.on_acknowledgement(acknowledgement)
            self._play.on_acknowledgement(acknowledgement)

    def _read_ticks(self) -> None:
        max_rate, waiting = self._topics.max_rate, self._reader.waiting
        self._read_timer.period = self._pace.period(max_rate)
        records = self._reader.take(self._pace.at_once(waiting, max_rate))
        if not len(records):
            return
        if waiting > len(records):
            self._read_timer.next_call = time.monotonic() + self._pace.pause(max_rate)
        self._topics.attach(self._reader.schema)
        for tick in StampedTick.from_records(records):
            self._on_tick(tick)

    def _on_tick(self, tick: StampedTick) -> None:
        if self._clock is not None:
            tick = self._clock.stamp(tick)
        if self._latest is not None:
            self._log_changes(self._latest, tick)
        self._latest = tick
        self._diagnostics.on_tick(tick)
        self._play.on_tick(tick)
        self._topics.publish(tick)
        self._navigate.on_tick(tick)
        self._follow.on_tick(tick)
        self._simulation.on_tick(tick)  # last: it tells that goals of before a reset are aborted

    def _log_changes(self, previous: StampedTick, tick: StampedTick) -> None:
        if tick.run != previous.run:
            logger.info("the robot was reset")
            self._joint_topics.cancel_trajectory()
        elif tick.mode is Mode.FALLEN and previous.mode is not Mode.FALLEN:
            logger.error("the robot fell")

    def stop(self) -> None:
        """Abort the goals in progress, because the loop ends."""
        for action in (self._navigate, self._play, self._follow):
            action.abort("the robot's loop has ended")
