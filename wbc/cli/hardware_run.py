"""A run of the walker on a robot outside this process, which `wbc walk --hardware` starts."""

from __future__ import annotations

import contextlib
import select
import sys
from array import array
from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

import numpy as np

import wbc
from wbc.cli.exit_code import ExitCode
from wbc.cli.interrupt import exit_on_interrupt, graceful_interrupt
from wbc.cli.outputs import RunOutputs
from wbc.cli.progress import ProgressLine
from wbc.cli.scripted_run import CommandEvents, RunOptions, Schedule
from wbc.errors import WbcError
from wbc.gait import VelocityLimits
from wbc.hardware.safety.foot_load import feet_carry
from wbc.runtime.loop import StopRun
from wbc.runtime.real_time import RealTime, garbage_collection_paused, real_time_thread
from wbc.runtime.statistics import Progress
from wbc.view import Meshcat

if TYPE_CHECKING:
    from wbc.hardware import Hardware

#: What a robot is commanded through.
Kind = Literal["unitree", "ros2_control"]


def walk_on_hardware(
    options: RunOptions,
    hardware: Kind,
    interface: str,
    command_topic: str,
    duration: float,
    priority: int,
    make_schedule: Callable[[VelocityLimits], Schedule],
) -> ExitCode:
    """Start a robot, walk according to a schedule, and damp its joints.

    Args:
        options: parsed options; those of the simulation do not matter.
        hardware: what the robot is commanded through.
        interface: network interface that leads to a Unitree robot.
        command_topic: topic of the efforts of a `ros2_control` robot.
        duration: duration of the run after the start, s.
        priority: real-time priority of the loop, see `wbc.RealTime`.
        make_schedule: returns the schedule for the velocities that the gait can walk at.

    Raises:
        WbcError: bad input, or a robot that cannot be started.
    """
    if options.push or options.ground_truth:
        raise WbcError("--push and --ground-truth are for the simulator; leave them out")
    with contextlib.ExitStack() as stack:
        line = stack.enter_context(ProgressLine())
        with exit_on_interrupt():
            from wbc.hardware import SafeHardware

            name = "g1" if hardware == "unitree" else options.simulation.robot
            robot = options.simulation.model.load(name)
            outputs = RunOutputs(options.simulation.outputs, robot, np.zeros((0, 6)))
            simulated = hardware == "unitree" and interface == "lo"
            plant = SafeHardware(
                _connect(hardware, robot, interface, command_topic),
                ready=_feet() if simulated else _operator_and_feet(),
                on_transition=lambda change: line.print(str(change)),
            )
            stack.enter_context(plant)
            walker = wbc.Walker(
                robot,
                plant.dt,
                planner=options.simulation.planner,
                solver=options.simulation.solver,
            )
            _warm_up(walker)
        schedule = list(make_schedule(walker.gait.max_velocity))
        observers = outputs.open_observers(stack)
        if options.view:
            observers.append(stack.enter_context(Meshcat(robot)))
        interrupted = stack.enter_context(graceful_interrupt())
        stack.enter_context(garbage_collection_paused())
        line.print(stack.enter_context(real_time_thread(RealTime(priority))).describe())

        told = CommandEvents(walker, (), observers)

        late = array("d")  # s

        def command(time: float) -> None:
            late.append(plant.lateness)
            if interrupted:
                raise StopRun("interrupted")
            while schedule and time >= schedule[0][0]:
                walker.velocity = schedule.pop(0)[1]
            told.on_tick(time)

        def progress(now: Progress) -> None:
            line.show_run(now)

        report = wbc.run(
            walker, plant, duration, observers=observers, before_tick=command, progress=progress,
            on_falling=lambda text: line.print(f"the robot is {text}"),
        )  # fmt: skip
        late.append(plant.lateness)
        latency = plant.latency.seconds
    print(report.table())
    connection = plant.connection
    print(
        f"connection: {connection.received} state messages, {plant.lost} lost, "
        f"{connection.corrupt} corrupt, {connection.reordered} out of order; latency "
        + ("unknown" if latency is None else f"{1e3 * latency:.0f} ms")
        + f"\n{lateness_line(np.array(late[1:]), plant.dt)}"
    )
    outputs.write(report)
    if interrupted:
        return ExitCode.INTERRUPTED
    return ExitCode.SUCCESS if report.survived else ExitCode.FAILED


def _connect(kind: Kind, robot: wbc.Robot, interface: str, command_topic: str) -> Hardware:
    """Return the connection to a robot."""
    if kind == "unitree":
        from wbc.hardware.unitree import connect as unitree

        return unitree.connect(interface, robot)
    from wbc.hardware.ros2_control import connect as ros2_control
    from wbc.hardware.ros2_control.robot import Ros2ControlConfig

    return ros2_control.connect(robot, Ros2ControlConfig(command_topic=command_topic))


def lateness_line(late: np.ndarray, dt: float) -> str:
    """Return how far the commands of a run were behind the robot's clock.

    Args:
        late: delay of each command, s.
        dt: control period, s.
    """
    if not late.size:
        return "no command was sent"
    median, most, worst = 1e3 * np.percentile(late, (50, 99, 100))
    return (
        f"commands behind the robot's clock by {median:.2f} / {most:.2f} / {worst:.2f} ms "
        f"(median / 99 % / max), {np.count_nonzero(late > dt)} of {late.size} by more than a period"
    )


def _warm_up(walker: wbc.Walker) -> None:
    """Load and compile what the first ticks of every kind need."""
    state, estimator = walker.robot.standing(), wbc.Estimator(walker.robot, walker.dt)
    still = np.zeros(walker.robot.na)
    gravity = -np.array(walker.robot.model.gravity.linear)
    m = wbc.Measurement(0.0, state.q[7:], still, np.zeros(3), gravity, joint_torque=still)
    walker.velocity = (0.1, 0.0, 0.0)
    walker.reset(state)
    for _ in range(round(2.0 * walker.gait_cycle / walker.dt)):
        walker.step(estimator.update(m))
    walker.velocity = (0.0, 0.0, 0.0)


def _operator_and_feet() -> Callable[[float | None], bool]:
    """Return a question to the operator that does not wait for the answer."""
    asked = False

    def ready(load: float | None) -> bool:
        nonlocal asked
        if not asked:
            asked = True
            print("Lower the robot until its feet carry it, then press Enter.", file=sys.stderr)
        if not select.select([sys.stdin], [], [], 0.0)[0]:
            return False
        if not feet_carry(load):
            sys.stdin.readline()
            print(
                f"Its feet carry {100.0 * (load or 0.0):.0f} % of its weight. Lower it further, "
                "then press Enter.",
                file=sys.stderr,
            )
            return False
        return True

    return ready


def _feet() -> Callable[[float | None], bool]:
    """Return whether the feet of a simulated robot carry it, and say so if they do not."""
    told = False

    def ready(load: float | None) -> bool:
        nonlocal told
        if not (told or feet_carry(load)):
            told = True
            print("Lower the robot until its feet carry it.", file=sys.stderr)
        return feet_carry(load)

    return ready
