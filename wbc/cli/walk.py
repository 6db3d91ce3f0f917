"""`wbc walk`: a robot walks in MuJoCo, with a report."""

from __future__ import annotations

from typing import Annotated, Literal

from wbc.cli.argument_types import Argument, Priority, Seconds, number
from wbc.cli.exit_code import ExitCode
from wbc.cli.scripted_run import RunOptions, Schedule, ScriptedRun, Velocity
from wbc.errors import WbcError
from wbc.gait import VelocityLimits
from wbc.runtime.real_time import DEFAULT_PRIORITY

_DURATION = 10.0  # s
_DEFAULT_SPEED = 0.3  # m/s, but at most
_SPEED_FRACTION = 0.4  # of the maximum speed
_INITIAL_STAND = 1.0  # s of standing before the first step
_FINAL_STAND = 3.0  # s for the last steps, and to stand
#: The segments of `--tour`: duration, s, and the fractions of the robot's maximum velocity.
_TOUR = (
    (6.0, (0.5, 0.0, 0.0)),  # forward
    (7.0, (0.4, 0.0, 0.5)),  # a curve
    (5.0, (0.0, 0.5, 0.0)),  # to the left
    (4.0, (0.0, 0.0, -0.6)),  # a turn in place
    (4.0, (-0.35, 0.0, 0.0)),  # backward
)
#: Duration of a tour, including the initial and final standing, s.
TOUR_DURATION = _INITIAL_STAND + sum(duration for duration, _ in _TOUR) + _FINAL_STAND


def walk(
    run: RunOptions,
    *,
    velocity: Annotated[Velocity | None, Argument(("VX", "VY", "WZ"), number)] = None,
    tour: bool = False,
    duration: Seconds | None = None,
    hardware: Literal["unitree", "ros2_control"] | None = None,
    interface: Annotated[str, Argument("IFACE")] = "lo",
    command_topic: Annotated[str, Argument("TOPIC")] = "/effort_controller/commands",
    priority: Priority = DEFAULT_PRIORITY,
) -> ExitCode:
    """Simulate a walking robot in MuJoCo under torque control and print a report.

    The robot stands for a second, walks, and stops in time to end standing.

    Args:
        run: robot, ground and pushes.
        velocity: forward and left velocity, m/s, and turn to the left, rad/s (default: forward at
            a moderate speed).
        tour: walk forward, in a curve, sideways, turn in place, and walk backward.
        duration: duration, s (default: 10; tour: 30).
        hardware: walk a robot outside of this process: a Unitree G1 in its development mode, or
            the stand-in of wbc robot unitree-g1; or the robot that ROBOT describes, whose joints
            take efforts from ros2_control.
        interface: network interface that leads to a Unitree robot.
        command_topic: topic of ros2_control that takes the efforts, in the order of the model.
        priority: real-time priority of the loop with --hardware (SCHED_FIFO), 0 for none; what the
            system grants is printed.
    """
    if tour and velocity is not None:
        raise WbcError("--tour and --velocity exclude each other; give one of them")
    duration = duration or (TOUR_DURATION if tour else _DURATION)

    def schedule(max_velocity: VelocityLimits) -> Schedule:
        if tour:
            return tour_schedule(max_velocity)
        default = (min(_DEFAULT_SPEED, _SPEED_FRACTION * max_velocity.forward), 0.0, 0.0)
        return walk_schedule(velocity or default, duration)

    if hardware is not None:
        from wbc.cli.hardware_run import walk_on_hardware

        return walk_on_hardware(
            run, hardware, interface, command_topic, duration, priority, schedule
        )
    scripted = ScriptedRun(run, duration)
    return scripted.walk(schedule(scripted.walker.gait.max_velocity))


def walk_schedule(velocity: Velocity, duration: float) -> Schedule:
    """Return a schedule that stands, walks at one velocity and stands again.

    Args:
        velocity: forward and left, m/s, and turn, rad/s.
        duration: duration of the whole schedule, s.
    """
    start = min(_INITIAL_STAND, 0.1 * duration)
    return [(start, velocity), (duration - min(_FINAL_STAND, 0.3 * duration), (0.0, 0.0, 0.0))]


def tour_schedule(max_velocity: VelocityLimits) -> Schedule:
    """Return a schedule that walks forward, in a curve, sideways, in place and backward.

    Args:
        max_velocity: velocities that the gait can walk at.
    """
    time, schedule = _INITIAL_STAND, []
    limits = max_velocity.largest
    for duration, fractions in (*_TOUR, (_FINAL_STAND, (0.0, 0.0, 0.0))):
        forward, left, turn = (f * v for f, v in zip(fractions, limits, strict=True))
        schedule.append((time, (forward, left, turn)))
        time += duration
    return schedule
