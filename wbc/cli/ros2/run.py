"""`wbc ros2 walk` and `wbc ros2 joint-publisher`."""

from __future__ import annotations

import argparse
import math
from typing import Annotated

from wbc.cli import teleoperated_run
from wbc.cli.argument_types import Argument, Priority, Seconds
from wbc.cli.exit_code import ExitCode
from wbc.cli.interrupt import graceful_interrupt
from wbc.cli.ros2.network import NetworkOptions, Rate
from wbc.cli.simulation import Session, Simulation, SimulationOptions
from wbc.robot.registry import data_file_folder
from wbc.ros import Node
from wbc.ros.arguments import RosArguments
from wbc.ros.bridge import Bridge
from wbc.ros.joint_publisher import JointPublisher
from wbc.ros.rosout import log_to_rosout
from wbc.runtime.real_time import RealTime
from wbc.teleop import CommandHandler
from wbc.view import Meshcat

_ROS_ARGUMENTS = Argument("...", nargs=argparse.REMAINDER)


def joint_publisher(
    network: NetworkOptions, *, rate: Rate = 50.0, duration: Seconds = math.inf
) -> None:
    """Publish a pattern of fifteen joints.

    Args:
        network: the network.
        rate: rate of /joint_states, 1 to 500 Hz.
        duration: stop after S seconds.
    """
    with Node("joint_publisher", network=network.network()) as node, log_to_rosout(node):
        JointPublisher(node, rate, data_file_folder() / "simple_humanoid.urdf")
        print(f"[INFO] [joint_publisher]: Joint publisher started at {rate} Hz")
        with graceful_interrupt() as interrupted:
            node.spin_until(lambda: interrupted, duration)


def walk(
    simulation: SimulationOptions,
    network: NetworkOptions,
    *,
    rate: Rate = 50.0,
    view: bool = False,
    as_fast_as_possible: bool = False,
    priority: Priority | None = None,
    sim_time: bool = False,
    name: str = "wbc",
    namespace: str = "/",
    mesh_files: bool = False,
    ros_args: Annotated[tuple[str, ...], _ROS_ARGUMENTS] = (),
    duration: Seconds = teleoperated_run.DURATION,
) -> ExitCode:
    """Simulate a robot that a ROS 2 system drives.

    Args:
        simulation: robot and ground.
        network: the network.
        rate: rate of /joint_states, 1 to 500 Hz; the node's parameter update_rate.
        view: show the robot in the browser.
        as_fast_as_possible: run faster than real time.
        priority: real-time priority of the loop (SCHED_FIFO), 0 for none (default: 40, but none in
            a niced process); what the system grants is printed.
        sim_time: stamp messages with the time of /clock, for nodes with use_sim_time; the node's
            parameter use_sim_time.
        name: name of the node.
        namespace: namespace of the node and its topics.
        mesh_files: name the files of meshes in robot_description, which RViz on this machine finds
            without the packages of the robot.
        ros_args: the rest of the line is as for nodes of ROS 2, e.g. -r __node:=legs
            -r cmd_vel:=/teleop/cmd_vel -p state_rate:=100.0.
        duration: duration, s.
    """
    given = RosArguments.parse(ros_args)
    simulated = Simulation(simulation)
    robot = simulated.robot

    def connect(handler: CommandHandler, session: Session) -> Bridge:
        if view:
            viewer = Meshcat(robot, boxes=simulated.boxes)
            session.observers.append(session.stack.enter_context(viewer))
        bridge = Bridge(
            handler,
            name=given.name or name,
            namespace=given.namespace or namespace,
            parameters=given.parameters,
            remappings=given.remappings,
            mesh_files=mesh_files,
            network=network.network(),
            update_rate=rate,
            use_sim_time=sim_time,
        )
        session.stack.enter_context(bridge)
        where = f"DDS domain {bridge.network.domain_id}, {bridge.network.scope}"
        print(
            f"[INFO] [{bridge.name}]: {robot.name} is ready; listening on /cmd_vel ({where}). "
            "Press Ctrl-C to stop."
        )
        return bridge

    # The loop keeps the time, which need not be that of the wall clock.
    real_time = not as_fast_as_possible and RealTime(priority)
    return teleoperated_run.run(simulated, duration, connect, owns_clock=False, real_time=real_time)
