"""A simulated Unitree G1 that speaks the low-level interface of the real one."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from wbc.hardware.unitree.gantry import Gantry
from wbc.hardware.unitree.messages import LOW_COMMAND, LOW_STATE, MessageBuffer
from wbc.hardware.unitree.motors import G1_MACHINES, SERIES_MODE, motor_of_joint
from wbc.robot import load
from wbc.robot.attitude import attitude
from wbc.servo import ServoCommand, ServoGains
from wbc.sim import JointServos, Mujoco, SensorNoise
from wbc.state import State

PERIOD = 0.002  #: s, of the state messages
_COMMAND_TIMEOUT = 0.02  # s without a valid command until the joints are damped
_DAMPING = 3.0  # N·m·s/rad
_FRICTION = 0.02  # share of the torque limit
_START_OFFSET = 0.15  # rad, largest distance of a joint from the nominal posture at the start


class G1StandIn:
    """A G1 with 29 joints in MuJoCo, behind the bytes of `LowCmd` and `LowState`.

    It starts in a gantry, some centimetres above the floor, with its joints damped; the gantry
    lowers it once its joints hold a posture, and lets go once they get feed-forward torques. Its
    joints are damped whenever no valid command has come for 20 ms.

    Args:
        seed: seed of sensor noise and start posture.
        latency: age of a command when it reaches the servos, s.
        noise: noise of the sensors.
        machine: `mode_machine` that it reports.

    Attributes:
        robot: its model.
        plant: the physics.
        damped: whether the joints are damped because no valid command came.
        corrupt: commands with a wrong checksum, which were ignored.
    """

    def __init__(
        self,
        *,
        seed: int = 0,
        latency: float = 0.0,
        noise: SensorNoise | None = None,
        machine: int = G1_MACHINES[0],
    ) -> None:
        self.robot = robot = load("g1")
        zero = np.zeros(robot.na)
        servos = JointServos(ServoGains(zero, zero), friction=_FRICTION, backlash=0.0)
        self.plant = Mujoco(
            robot,
            dt=PERIOD,
            seed=seed,
            latency=latency,
            noise=noise,
            servos=servos,
            foot_sensors=False,
        )
        standing = robot.standing()
        q = standing.q.copy()
        offsets = np.random.default_rng(seed).uniform(-_START_OFFSET, _START_OFFSET, robot.na)
        q[7:] = np.clip(q[7:] + offsets, robot.q_min, robot.q_max)
        self._gantry = Gantry(robot)
        self._pushes: list[tuple[float, Sequence[float]]] = []
        q[2] += self._gantry.lift
        self.plant.reset(State(q, np.zeros(robot.nv)))
        self._motors = motor_of_joint(robot)
        self._state, self._command = MessageBuffer(LOW_STATE), MessageBuffer(LOW_COMMAND)
        self._state.fields["mode_machine"] = machine
        self._state.fields["mode_pr"] = SERIES_MODE
        self._state.fields["motor_state"]["mode"][0, self._motors] = 1
        self._damping = ServoCommand(zero, zero, zero, zero, np.full(robot.na, _DAMPING))
        self._held = self._damping
        self._commanded_at = -math.inf
        self.damped = True
        self.corrupt = 0

    def schedule_push(self, delay: float, impulse: Sequence[float]) -> None:
        """Push the torso for 0.1 s some time after the gantry has let go.

        Args:
            delay: time since then, s.
            impulse: (3,) world axes, N·s.
        """
        self._pushes.append((delay, impulse))

    def take(self, data: bytes) -> None:
        """Take in the bytes of a command; one with a wrong checksum is ignored."""
        if not self._command.decode(data):
            self.corrupt += 1
            return
        commands = self._command.fields["motor_cmd"][0][self._motors]
        on = (commands["mode"] == 1).astype(float)
        q, v, tau, kp, kd = (
            on * commands[name].astype(float) for name in ("q", "dq", "tau", "kp", "kd")
        )
        if not all(np.isfinite(values).all() for values in (q, v, tau, kp, kd)):
            self.corrupt += 1
            return
        self._held = ServoCommand(q, v, tau, kp, kd)
        self._commanded_at = self.plant.time

    def step(self) -> None:
        """Advance by one period."""
        plant = self.plant
        self.damped = plant.time - self._commanded_at > _COMMAND_TIMEOUT - 1e-9
        command = self._damping if self.damped else self._held
        self._gantry.apply(plant, command)
        if self._pushes and self._gantry.released:
            for delay, impulse in self._pushes:
                plant.schedule_push(plant.time + delay, impulse)
            self._pushes.clear()
        plant.step(command)

    @property
    def damping(self) -> bool:
        """Whether the joints are damped, by command or because none came."""
        return self.damped or not (self._held.kp.any() or self._held.tau.any())

    def state_message(self) -> bytes:
        """Return the bytes of the present state."""
        m, state = self.plant.measure(), self._state.fields
        state["tick"] = round(1e3 * m.time)
        motors = state["motor_state"][0]
        motors["q"][self._motors] = m.joint_position
        motors["dq"][self._motors] = m.joint_velocity
        motors["tau_est"][self._motors] = m.joint_torque
        imu = state["imu_state"][0]
        x, y, z, w = attitude(self.robot, self.plant.ground_truth())
        imu["quaternion"] = (w, x, y, z)
        imu["gyroscope"], imu["accelerometer"] = m.gyro, m.accelerometer
        return self._state.encode()
