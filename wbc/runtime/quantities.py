"""The quantities of a tick. To add one, add one entry: log, page, plots and ROS follow."""

from __future__ import annotations

import numpy as np

from wbc.command import Status
from wbc.runtime.schema import ODOM, WRENCH, XYZ, Quantity
from wbc.telemetry import PHASES

#: Values of `Status` by their numbers in a record.
STATUSES = tuple(Status)
_PHASE_NUMBERS = {phase: i for i, phase in enumerate(PHASES)}

QUANTITIES: tuple[Quantity, ...] = (
    # The tick and its timing.
    Quantity("time", "time", "plant time", "s", message="composite"),
    Quantity("wall_time", "wall_time", "when the tick ended, since 1970", "s", message="composite"),
    Quantity("tick", "index", "number of the tick in its run", message="composite"),
    Quantity("run", "run", "number of the run, counted from 1", message="composite"),
    Quantity("mode", lambda tick: 0, "of the loop, see `Mode`", message="composite"),
    Quantity(
        "estimator_time", "estimator_time", "time that the estimator took", "s", message="composite"
    ),
    Quantity(
        "controller_time", "controller_time", "time that the controller took", "s",
        message="composite",
    ),
    Quantity("period", "period", "wall time since the tick before", "s", message="composite"),
    # The measurement.
    Quantity(
        "joint_position", "measurement.joint_position", "encoder positions", "rad", size="na",
        message="composite", single=True,
    ),
    Quantity(
        "joint_velocity", "measurement.joint_velocity", "encoder velocities", "rad/s", size="na",
        message="composite", single=True,
    ),
    Quantity(
        "gyro", "measurement.gyro", "angular velocity of the IMU", "rad/s", size=3, labels=XYZ,
        frame="{imu}", message="composite", single=True,
    ),
    Quantity(
        "accelerometer", "measurement.accelerometer", "specific force of the IMU", "m/s²", size=3,
        labels=XYZ, frame="{imu}", message="composite", single=True,
    ),
    Quantity(
        "foot_wrench/{sole}", "measurement.foot_wrenches", "measured wrench on the foot",
        "N, N·m", size=6, labels=WRENCH, frame="{sole}", message="wrench",
        topic="sensors/wrench/{sole}",
    ),
    # The estimate.
    Quantity("q", "estimate.state.q", "estimated configuration", "m, rad", size="nq",
             frame=ODOM, message="composite"),
    Quantity("v", "estimate.state.v", "estimated velocity, base twist in the base frame",
             "m/s, rad/s", size="nv", frame="{base}", message="composite"),
    # The command.
    Quantity(
        "status", lambda tick: STATUSES.index(tick.command.status),
        "how the QP ended: " + ", ".join(f"{i} {s.value}" for i, s in enumerate(STATUSES)),
        message="composite",
    ),
    Quantity("tau", "command.tau", "commanded joint torques", "N·m", size="na",
             message="composite"),
    Quantity(
        "acceleration", "command.acceleration", "planned generalised acceleration", "m/s², rad/s²",
        size="nv", topic="command/acceleration", single=True,
    ),
    Quantity(
        "q_target", "command.q_target", "joint positions one period ahead", "rad", size="na",
        message="composite", single=True,
    ),
    Quantity(
        "v_target", "command.v_target", "joint velocities one period ahead", "rad/s", size="na",
        message="composite", single=True,
    ),
    # What the controller tells.
    Quantity("com", "telemetry.com", "centre of mass", "m", size=3, labels=XYZ, frame=ODOM,
             message="point", topic="balance/com"),
    Quantity("dcm", "telemetry.dcm", "divergent component of motion", "m", size=3, labels=XYZ,
             frame=ODOM, message="point", topic="balance/dcm"),
    Quantity("dcm_reference", "telemetry.dcm_reference", "planned DCM", "m", size=3, labels=XYZ,
             frame=ODOM, message="point", topic="balance/dcm_reference"),
    Quantity("zmp", "telemetry.zmp", "commanded ZMP", "m", size=3, labels=XYZ, frame=ODOM,
             message="point", topic="balance/zmp"),
    Quantity("velocity_command", "telemetry.velocity", "commanded walking velocity", "m/s, rad/s",
             size=3, labels=("forward", "left", "turn"), message="composite"),
    Quantity("heading", "telemetry.heading", "mean heading of the soles", "rad"),
    Quantity("dcm_error", "telemetry.dcm_error", "distance of the DCM from its reference", "m",
             message="composite"),
    Quantity(
        "phase", lambda tick: _PHASE_NUMBERS.get(tick.telemetry.phase, 0),
        "gait phase: " + ", ".join(f"{i} {phase}" for i, phase in enumerate(PHASES)),
        message="composite",
    ),
    Quantity("steps", "telemetry.steps", "touchdowns since the reset", message="composite"),
    # The truth, from a simulator.
    Quantity(
        "true_q", lambda tick: tick.truth.q if tick.truth else np.nan, "true configuration",
        "m, rad", size="nq", frame=ODOM, message="composite", single=True,
    ),
    Quantity(
        "true_v", lambda tick: tick.truth.v if tick.truth else np.nan,
        "true velocity, base twist in the base frame", "m/s, rad/s", size="nv", frame="{base}",
        message="composite", single=True,
    ),
)  # fmt: skip
