"""The quantities of a tick. To add one, add one entry: log, page, plots and ROS follow."""

from __future__ import annotations

from functools import partial

import numpy as np

from wbc.command import Status
from wbc.runtime.schema import ODOM, WRENCH, XYZ, Quantity
from wbc.telemetry import PHASES

#: Values of `Status` by their numbers in a record.
STATUSES = tuple(Status)
_PHASE_NUMBERS = {phase: i for i, phase in enumerate(PHASES)}


def _numbered(values: tuple[str, ...]) -> str:
    return ", ".join(f"{i} {value}" for i, value in enumerate(values))


#: A quantity that travels in a message with others.
_part = partial(Quantity, message="composite")
#: One that is kept in single precision.
_single = partial(_part, single=True)
#: A point in space.
_point = partial(Quantity, unit="m", size=3, labels=XYZ, frame=ODOM, message="point")

QUANTITIES: tuple[Quantity, ...] = (
    # The tick and its timing.
    _part("time", "time", "plant time", "s"),
    _part("wall_time", "wall_time", "when the tick ended, since 1970", "s"),
    _part("tick", "index", "number of the tick in its run"),
    _part("run", "run", "number of the run, counted from 1"),
    _part("mode", lambda tick: 0, "of the loop, see `Mode`"),
    _part("estimator_time", "estimator_time", "time that the estimator took", "s"),
    _part("controller_time", "controller_time", "time that the controller took", "s"),
    _part("period", "period", "wall time since the tick before", "s"),
    # The measurement.
    _single("joint_position", "measurement.joint_position", "encoder positions", "rad", "na"),
    _single("joint_velocity", "measurement.joint_velocity", "encoder velocities", "rad/s", "na"),
    _single("gyro", "measurement.gyro", "angular velocity of the IMU", "rad/s", 3, XYZ, "{imu}"),
    _single("accelerometer", "measurement.accelerometer", "specific force of the IMU", "m/s²", 3,
            XYZ, "{imu}"),
    Quantity("foot_wrench/{sole}", "measurement.foot_wrenches", "measured wrench on the foot",
             "N, N·m", 6, WRENCH, "{sole}", message="wrench", topic="sensors/wrench/{sole}"),
    # The estimate.
    _part("q", "estimate.state.q", "estimated configuration", "m, rad", "nq", frame=ODOM),
    _part("v", "estimate.state.v", "estimated velocity, base twist in the base frame",
          "m/s, rad/s", "nv", frame="{base}"),
    # The command.
    _part("status", lambda tick: STATUSES.index(tick.command.status),
          "how the QP ended: " + _numbered(tuple(s.value for s in STATUSES))),
    _part("tau", "command.tau", "commanded joint torques", "N·m", "na"),
    Quantity("acceleration", "command.acceleration", "planned generalised acceleration",
             "m/s², rad/s²", "nv", topic="command/acceleration", single=True),
    _single("q_target", "command.q_target", "joint positions one period ahead", "rad", "na"),
    _single("v_target", "command.v_target", "joint velocities one period ahead", "rad/s", "na"),
    # Telemetry of the controller.
    _point("com", "telemetry.com", "centre of mass", topic="balance/com"),
    _point("dcm", "telemetry.dcm", "divergent component of motion", topic="balance/dcm"),
    _point("dcm_reference", "telemetry.dcm_reference", "planned DCM",
           topic="balance/dcm_reference"),
    _point("zmp", "telemetry.zmp", "commanded ZMP", topic="balance/zmp"),
    _part("velocity_command", "telemetry.velocity", "commanded walking velocity", "m/s, rad/s", 3,
          ("forward", "left", "turn")),
    Quantity("heading", "telemetry.heading", "mean heading of the soles", "rad"),
    _part("dcm_error", "telemetry.dcm_error", "distance of the DCM from its reference", "m"),
    _part("phase", lambda tick: _PHASE_NUMBERS.get(tick.telemetry.phase, 0),
          "gait phase: " + _numbered(PHASES)),
    _part("steps", "telemetry.steps", "touchdowns since the reset"),
    # The truth, from a simulator.
    _single("true_q", lambda tick: tick.truth.q if tick.truth else np.nan, "true configuration",
            "m, rad", "nq", frame=ODOM),
    _single("true_v", lambda tick: tick.truth.v if tick.truth else np.nan,
            "true velocity, base twist in the base frame", "m/s, rad/s", "nv", frame="{base}"),
)  # fmt: skip
