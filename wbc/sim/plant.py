"""A humanoid in MuJoCo, torque in and sensor readings out."""

from __future__ import annotations

import math
from collections import deque
from typing import Any

import numpy as np

from wbc.closeable import Closeable
from wbc.command import Command
from wbc.errors import PlantError
from wbc.measurement import Measurement
from wbc.robot import Robot
from wbc.robot.attitude import heading
from wbc.sim.convention import Convention
from wbc.sim.ground import Ground
from wbc.sim.model import build_model, import_mujoco
from wbc.sim.noise import Noise, SensorNoise
from wbc.sim.push import Push, Pushes
from wbc.sim.sensors import Sensors
from wbc.sim.terrain import Flat, Terrain
from wbc.state import State


class Mujoco(Closeable):
    """The simulated robot: motors, sensors, ground and pushes.

    A context manager. The same arguments and commands give the same run, bit by bit.

    Args:
        robot: its model is copied: later changes to it do not reach the plant.
        dt: control period, a multiple of `timestep`, s.
        timestep: of the physics, s.
        friction: Coulomb coefficient between soles and ground.
        terrain: what lies on the floor; laid around the robot's pose at reset.
        noise: of the sensors.
        ground_truth: measurements carry the exact state.
        seed: of the sensor noise, which starts anew at every reset.
        latency: age of a command when it reaches the motors, s.
        feet_collide: the soles also meet each other, as boxes of 2 cm. Nothing else of
            the robot collides: limbs pass through each other, a fallen robot through the
            floor.

    Raises:
        PlantError: a model that MuJoCo cannot represent, or times that do not fit.
        MissingExtra: `mujoco` is not installed.
    """

    def __init__(
        self,
        robot: Robot,
        *,
        dt: float = 0.002,
        timestep: float = 0.001,
        friction: float = 0.8,
        terrain: Terrain | None = None,
        noise: SensorNoise | None = None,
        ground_truth: bool = False,
        seed: int = 0,
        latency: float = 0.0,
        feet_collide: bool = True,
    ) -> None:
        self.robot = robot
        self.dt = dt
        self.timestep = timestep
        self.terrain: Terrain = Flat() if terrain is None else terrain
        self._substeps = _whole_steps("dt", dt, timestep, least=1)
        self.latency = latency
        self._latency_steps = _whole_steps("latency", latency, timestep, least=0)
        self._give_truth = ground_truth
        self.noise = SensorNoise() if noise is None else noise
        self.seed = seed
        self._mujoco = import_mujoco()
        self._ground = Ground(self.terrain)
        self.model = build_model(
            robot,
            timestep=timestep,
            friction=friction,
            ground=self._ground,
            feet_collide=feet_collide,
        )
        self.data = self._mujoco.MjData(self.model)
        self._scratch: Any = None
        dofs = [self.model.joint(name).dofadr[0] - 6 for name in robot.joint_names]
        self.convention = Convention(np.array(dofs, dtype=int))
        self._sensors = Sensors(robot, self._mujoco, self.model, self.data, self.convention)
        self._pushes = Pushes(self._mujoco, self.model, self.data)
        first = 2 * robot.na + 6
        self._wrench_places = [
            (s.name, slice(first + 6 * i, first + 6 * i + 6)) for i, s in enumerate(robot.soles)
        ]
        self._tau_max = np.array(robot.tau_max, dtype=float)
        self._tau_min = -self._tau_max
        self._commands: deque[tuple[int, np.ndarray]] = deque()
        self.reset()

    def close(self) -> None:
        """Nothing to release: MuJoCo's memory goes with the object."""

    @property
    def time(self) -> float:
        """Since the last reset, s."""
        return self._steps * self.timestep

    def reset(self, state: State | None = None) -> None:
        """Start over at a state, by default `robot.standing()`, with motors off.

        The terrain moves along: the robot finds it as `robot.standing()` finds it at the
        world's origin, whatever place and heading it starts at. The first measurement is
        that of the posture held still: see `Sensors.start`.

        Raises:
            StateError: wrong sizes, NaN or a quaternion that is not of unit length.
        """
        state = (self.robot.standing() if state is None else state).validated(self.robot.model)
        mujoco, model, data = self._mujoco, self.model, self.data
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:] = self.convention.to_plant(state)
        self._lay_ground(state)
        self._steps = 0
        self._commands.clear()
        self._pushes.clear()
        self._noise = Noise(self.noise, self.robot.na, len(self.robot.soles), self.seed)
        mujoco.mj_forward(model, data)
        self._sensors.start()
        self._measurement: Measurement | None = None

    def measure(self) -> Measurement:
        """What the sensors read now; asked twice in a tick, the same object."""
        if self._measurement is None:
            n, r = 2 * self.robot.na, self._noise.corrupt(self._sensors.reading)
            self._measurement = Measurement(
                time=self.time,
                joint_position=r[: n // 2],
                joint_velocity=r[n // 2 : n],
                gyro=r[n : n + 3],
                accelerometer=r[n + 3 : n + 6],
                foot_wrenches={name: r[at] for name, at in self._wrench_places},
                ground_truth=self.ground_truth() if self._give_truth else None,
            )
        return self._measurement

    def step(self, command: Command) -> None:
        """Hold a command's torques over one control period.

        Torques beyond the robot's limits are clipped to them; `torque` tells what the
        motors do.

        Raises:
            PlantError: torques of the wrong size or not finite, or physics that diverged.
        """
        self._queue(command.tau)
        mujoco, model, data, commands = self._mujoco, self.model, self.data, self._commands
        self._ground.follow(data)
        for _ in range(self._substeps):
            while commands and commands[0][0] <= self._steps:
                data.ctrl[:] = commands.popleft()[1]
            self._pushes.apply(self._steps)
            # mj_step's two halves, turned round: the tick ends with fresh kinematics.
            mujoco.mj_step2(model, data)
            self._sensors.accumulate()
            mujoco.mj_step1(model, data)
            self._steps += 1
        velocity = data.qvel
        if not math.isfinite(velocity.dot(velocity)):
            raise PlantError(f"the physics diverged at {self.time:.3f} s: a smaller timestep helps")
        self._sensors.update()
        self._measurement = None

    def push(self, impulse: Any, *, duration: float = 0.1, frame: str | None = None) -> None:
        """Push now: see `schedule_push`."""
        self.schedule_push(self.time, impulse, duration=duration, frame=frame)

    def schedule_push(
        self, at_time: float, impulse: Any, *, duration: float = 0.1, frame: str | None = None
    ) -> None:
        """A constant force that delivers an impulse, F = impulse / duration.

        Args:
            at_time: when it sets in, s; not before now.
            impulse: (3,) world axes, N·s.
            duration: rounded to whole physics steps, s; the impulse stays exact.
            frame: acts at this frame's origin; by default at the centre of mass of the
                body that carries the robot's torso.

        Raises:
            PlantError: a shape, a duration or a time that makes no sense.
            FrameNotFound: the model has no such frame.
        """
        vector = np.asarray(impulse, dtype=float)
        if vector.shape != (3,) or not np.isfinite(vector).all():
            raise PlantError(f"a push needs a finite (3,) impulse in N·s, not {impulse!r}")
        if not (np.isfinite(duration) and duration > 0.0):
            raise PlantError(f"a push of {duration} s: the duration must be positive")
        if not (np.isfinite(at_time) and at_time > self.time - 0.5 * self.timestep):
            raise PlantError(f"a push at {at_time} s: the time is {self.time:.3f} s already")
        joint, point = self._push_point(frame)
        first = round(at_time / self.timestep)
        steps = max(1, round(duration / self.timestep))
        force = vector / (steps * self.timestep)
        self._pushes.add(Push(first, first + steps, force, joint, point))

    def ground_truth(self) -> State:
        """The exact state now: for reports and tests, not for controllers."""
        return self.convention.to_state(self.data.qpos, self.data.qvel)

    @property
    def torque(self) -> np.ndarray:
        """(na,) what the motors exert now, N·m."""
        torque: np.ndarray = self.data.ctrl.copy()
        return torque

    @property
    def foot_forces(self) -> dict[str, np.ndarray]:
        """Sole name -> (6,) exact contact wrench of the last tick, in sole axes; N, N·m."""
        return {name: self._sensors.reading[at].copy() for name, at in self._wrench_places}

    @property
    def push_force(self) -> np.ndarray:
        """(3,) sum of the pushes that act now, world axes, N."""
        return self._pushes.force(self._steps)

    def contacts(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """(point, force on the robot) of each contact, world axes; m, N. Not for the loop."""
        mujoco, model = self._mujoco, self.model
        if self._scratch is None:
            self._scratch = mujoco.MjData(model)
        data = self._scratch
        mujoco.mj_copyData(data, model, self.data)
        mujoco.mj_forward(model, data)
        wrench = np.empty(6)
        root = model.body(self.robot.model.names[1]).id
        found = []
        for i in range(data.ncon):
            contact = data.contact[i]
            mujoco.mj_contactForce(model, data, i, wrench)
            first, second = (model.body_rootid[model.geom_bodyid[g]] for g in contact.geom)
            if first == second:
                continue
            # The contact's normal points from geom 1 to geom 2, and so does its force.
            sign = 1.0 if second == root else -1.0
            force = sign * (wrench[:3] @ contact.frame.reshape(3, 3))
            found.append((contact.pos.copy(), force))
        return found

    def _lay_ground(self, state: State) -> None:
        """Lay the terrain's origin where the robot that stands there was moved from."""
        yaw = heading(self.robot, state)
        c, s = math.cos(yaw), math.sin(yaw)
        x, y = self.robot.q_nominal[:2].tolist()
        at = state.q[0] - (c * x - s * y), state.q[1] - (s * x + c * y)
        self._ground.lay(self.data, float(at[0]), float(at[1]), yaw)

    def _queue(self, tau: np.ndarray) -> None:
        tau = np.asarray(tau, dtype=float)
        if tau.shape != self._tau_max.shape:
            raise PlantError(
                f"command.tau has shape {tau.shape}, the robot has {self.robot.na} joints"
            )
        if not math.isfinite(tau.dot(tau)) and not np.isfinite(tau).all():
            bad = np.flatnonzero(~np.isfinite(tau))
            name = self.robot.joint_names[bad[0]]
            raise PlantError(f"command.tau of joint '{name}' is not finite: the plant refuses it")
        clipped = np.minimum(np.maximum(tau, self._tau_min), self._tau_max)
        # The first command acts at once: a robot is never switched on without one.
        delay = self._latency_steps if self._steps else 0
        self._commands.append((self._steps + delay, clipped))

    def _push_point(self, frame: str | None) -> tuple[int, np.ndarray]:
        name = self.robot.torso if frame is None else frame
        placed = self.robot.model.frames[self.robot.frame_id(name)]
        body = self.model.body(self.robot.model.names[placed.parentJoint]).id
        if frame is None:
            return body, self.model.body_ipos[body].copy()
        return body, placed.placement.translation.copy()


def _whole_steps(name: str, value: float, timestep: float, least: int) -> int:
    """How many physics steps a time is, or a `PlantError`."""
    if not (np.isfinite(timestep) and timestep > 0.0):
        raise PlantError(f"timestep is {timestep}: it must be positive (s)")
    steps = round(value / timestep) if np.isfinite(value) else -1
    if steps < least or abs(steps * timestep - value) > 1e-9:
        raise PlantError(f"{name} = {value} s is not a whole number of {timestep} s timesteps")
    return steps
