"""A humanoid in MuJoCo: commands in, sensor readings out."""

from __future__ import annotations

import math
from typing import Any, Literal, get_args

import numpy as np

from wbc.closeable import Closeable
from wbc.command import Command
from wbc.errors import PhysicsDiverged, PlantError
from wbc.measurement import Measurement
from wbc.robot import Robot, checked_robot
from wbc.robot.attitude import heading
from wbc.servo import ServoCommand
from wbc.sim.cart import Cart
from wbc.sim.coordinates import CoordinateMap
from wbc.sim.ground import Ground
from wbc.sim.model import build_model, import_mujoco
from wbc.sim.motors import Motors
from wbc.sim.noise import NoiseGenerator, SensorNoise
from wbc.sim.payload import Payload, Payloads
from wbc.sim.pushes import Pull, Push, PushSchedule
from wbc.sim.robot_collisions import RobotCollisions, robot_collisions, touching_bodies
from wbc.sim.sensor_delay import SensorDelay
from wbc.sim.sensors import Sensors
from wbc.sim.servos import JointServos, Servos, set_friction
from wbc.sim.soft_ground import soften_ground
from wbc.sim.terrain import Flat, Terrain
from wbc.state import State

#: Root of the sum of squares of all velocities from which on the physics counts as diverged,
#: m/s and rad/s: several times what all motors of a humanoid together reach.
_MAX_SPEED = 1000.0

# A pull by a spring: length at which it would reach the robot's weight, m; largest force as a share
# of the weight; damping ratio with the whole mass of the robot.
_PULL_LENGTH, _PULL_SHARE, _PULL_DAMPING = 0.5, 0.5, 0.2

#: What of the robot collides.
Collisions = Literal["all", "soles"]


class Mujoco(Closeable):
    """The simulated robot: motors, sensors, ground and pushes.

    A context manager. The same arguments and commands give the same run, bit by bit. At any
    tick `copy.deepcopy` and `pickle` give a plant that goes on bit-identically, in this process
    or another.

    Args:
        robot: its model is copied: later changes to it do not reach the plant.
        dt: control period, a multiple of `timestep`, s.
        timestep: time step of the physics, s.
        friction: Coulomb coefficient between soles and ground.
        terrain: obstacles on the floor, placed around the robot's pose at each reset.
        noise: noise of the sensors.
        ground_truth: measurements carry the exact state.
        seed: seed of the sensor noise, which starts anew at every reset.
        latency: age of a command when it reaches the motors, s.
        sensor_latency: age of the readings when they are measured, a multiple of `dt`, s.
        ground_sink: depth to which the standing robot sinks into soft ground, m; 0: hard ground.
        foot_sensors: the soles have force sensors; without them the joints' torques are measured.
        servos: the joints are driven by such servos, which take positions, velocities and
            feed-forward torques; by default they are ideal sources of the commanded torque.
        collisions: "all": every body collides with the ground and with the others, but for
            those of `excluded_pairs`. "soles": only the soles do; limbs pass through each
            other, and a fallen robot through the floor.
        cart: an object to push, placed like the terrain; see `cart_position`.

    Attributes:
        collision_shapes: shapes of the robot's bodies beside its soles, which are boxes of 2 cm.
        excluded_pairs: bodies that pass through each other, and why.
        backlash: of the servos, rad; 0 without servos.

    Raises:
        PlantError: a model that MuJoCo cannot represent, times that do not fit, negative
            friction, a bad seed, or unknown collisions.
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
        sensor_latency: float = 0.0,
        ground_sink: float = 0.0,
        foot_sensors: bool = True,
        servos: JointServos | None = None,
        collisions: Collisions = "all",
        cart: Cart | None = None,
    ) -> None:
        self._substeps = _whole_steps("dt", dt, timestep, least=1)
        latency_steps = _whole_steps("latency", latency, timestep, least=0)
        self._delay = SensorDelay(_whole_steps("sensor_latency", sensor_latency, dt, least=0))
        if not (math.isfinite(ground_sink) and ground_sink >= 0.0):
            raise PlantError(f"ground_sink = {ground_sink} m must be finite and >= 0")
        if not (math.isfinite(friction) and friction >= 0.0):
            raise PlantError(f"friction = {friction}: a Coulomb coefficient is finite and >= 0")
        if not (isinstance(seed, int | np.integer) and seed >= 0):
            raise PlantError(f"seed = {seed!r}: the seed must be a whole number >= 0")
        if collisions not in get_args(Collisions):
            raise PlantError(
                f"collisions = {collisions!r} must be one of {', '.join(get_args(Collisions))}"
            )
        self.robot = checked_robot(robot, "Mujoco")
        self.dt = dt
        self.timestep = timestep
        self.latency = latency
        self.seed = seed
        self.terrain: Terrain = Flat() if terrain is None else terrain
        self.noise = SensorNoise() if noise is None else noise
        self._measures_truth = ground_truth
        self._foot_sensors = foot_sensors
        found = robot_collisions(robot) if collisions == "all" else RobotCollisions()
        self.collision_shapes = found.shapes
        self.excluded_pairs = found.excluded_pairs
        self._ground = Ground(self.terrain)
        self.model = build_model(
            robot,
            timestep=timestep,
            friction=friction,
            ground=self._ground,
            shapes=found.shapes,
            excluded_pairs=[(pair.first, pair.second) for pair in found.excluded_pairs],
            cart=cart,
        )
        self._cart = None if cart is None else int(self.model.joint("cart").qposadr[0])
        dofs = [self.model.joint(name).dofadr[0] - 6 for name in robot.joint_names]
        self.coordinates = CoordinateMap(np.array(dofs, dtype=int))
        if ground_sink > 0.0:
            standing = self.model.qpos0.copy()
            standing[: robot.nq], _ = self.coordinates.to_plant(robot.standing())
            soften_ground(import_mujoco(), self.model, standing, ground_sink, robot.weight)
        first = 2 * robot.na + 6
        self._wrench_slices = [
            (s.name, slice(first + 6 * i, first + 6 * i + 6)) for i, s in enumerate(robot.soles)
        ]
        self._motors = Motors(robot, latency_steps)
        self.backlash = 0.0 if servos is None else servos.backlash
        self._servos: Servos | None = None
        if servos is not None:
            self._servos = Servos(robot, servos, dt, timestep, latency_steps)
            set_friction(self.model, robot, servos, 6 + self.coordinates.order)
        self._pushes = PushSchedule()
        self._payloads = Payloads(self.model)
        self._connect()
        self.reset()

    def _connect(self) -> None:
        """Allocate MuJoCo's data, and everything that holds views of it."""
        self._mujoco = import_mujoco()
        self.data = self._mujoco.MjData(self.model)
        self._scratch: Any = None
        self._sensors = Sensors(
            self.robot,
            self._mujoco,
            self.model,
            self.data,
            self.coordinates,
            0 if self._foot_sensors else self.robot.na,
        )

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy needs: settings, model, the integration state and readings."""
        state = self.__dict__.copy()
        for name in ("_mujoco", "data", "_scratch", "_sensors"):
            del state[name]
        kind = self._mujoco.mjtState.mjSTATE_INTEGRATION
        physics = np.empty(self._mujoco.mj_stateSize(self.model, kind))
        self._mujoco.mj_getState(self.model, self.data, physics, kind)
        return state | {"physics": physics, "reading": self._sensors.reading}

    def __setstate__(self, state: dict[str, Any]) -> None:
        physics, reading = state.pop("physics"), state.pop("reading")
        self.__dict__.update(state)
        self._connect()
        mujoco = self._mujoco
        mujoco.mj_setState(self.model, self.data, physics, mujoco.mjtState.mjSTATE_INTEGRATION)
        mujoco.mj_step1(self.model, self.data)
        self._sensors.reading[:] = reading

    def __repr__(self) -> str:
        return (
            f"Mujoco({self.robot.name}, {self.terrain!r}, dt={self.dt} s, "
            f"timestep={self.timestep} s, seed={self.seed}, at {self.time:.3f} s)"
        )

    def close(self) -> None:
        """Do nothing: MuJoCo's memory is freed with the object."""

    @property
    def time(self) -> float:
        """Time since the last reset, s."""
        return self._steps * self.timestep

    def reset(self, state: State | None = None) -> None:
        """Start over at a state, by default `robot.standing()`, with motors off.

        The terrain moves along: the robot finds it as `robot.standing()` finds it at the
        world's origin, whatever position and heading it starts at. The first measurement is
        that of the posture held still: see `Sensors.reset`.

        Raises:
            StateError: wrong sizes, NaN or a quaternion that is not of unit length.
        """
        state = (self.robot.standing() if state is None else state).validated(self.robot.model)
        mujoco, model, data = self._mujoco, self.model, self.data
        self._payloads.clear(mujoco, model)
        mujoco.mj_resetData(model, data)
        robot = self.robot
        data.qpos[: robot.nq], data.qvel[: robot.nv] = self.coordinates.to_plant(state)
        self._place_ground(state)
        self._steps = 0
        self._motors.clear()
        if self._servos is not None:
            self._servos.clear()
        self._pushes.clear()
        limits = () if self._foot_sensors else self.robot.tau_max
        feet = len(self.robot.soles)
        self._noise = NoiseGenerator(self.noise, self.robot.na, feet, self.seed, limits)
        mujoco.mj_forward(model, data)
        self._sensors.reset()
        self._delay.clear(self._sensors.reading)
        self._measurement: Measurement | None = None

    def measure(self) -> Measurement:
        """Return what the sensors read now; the same object when asked twice in a tick."""
        if self._measurement is None:
            n, r = 2 * self.robot.na, self._delay.frozen(self.time)
            if r is None:
                r = self._noise.add_to(self._delay.oldest)
                self._delay.deliver(r)
            feet = self._wrench_slices if self._foot_sensors else []
            self._measurement = Measurement(
                time=self.time,
                joint_position=r[: n // 2],
                joint_velocity=r[n // 2 : n],
                gyro=r[n : n + 3],
                accelerometer=r[n + 3 : n + 6],
                foot_wrenches={name: r[at] for name, at in feet},
                ground_truth=self.ground_truth() if self._measures_truth else None,
                joint_torque=None if self._foot_sensors else r[-self.robot.na :],
            )
        return self._measurement

    def step(self, command: Command | ServoCommand) -> None:
        """Hold a command over one control period.

        A plant with servos also takes the command to these, as hardware does.

        Torques beyond the robot's limits are clipped to them; `torque` returns what the
        motors exert.

        Raises:
            PlantError: torques of the wrong size or not finite.
            PhysicsDiverged: velocities that are not finite or absurdly large.
        """
        mujoco, model, data, motors = self._mujoco, self.model, self.data, self._motors
        servos = self._servos
        if servos is not None:
            servos.command(command, self._steps)
        elif isinstance(command, ServoCommand):
            raise PlantError("a plant without servos takes a Command: make it with servos=…")
        else:
            motors.command(command, self._steps)
        self._ground.follow(data)
        self._payloads.update(self.time + 0.5 * self.timestep, mujoco, model)
        for _ in range(self._substeps):
            if servos is not None:
                data.ctrl[:] = servos.torque(self._steps, *self._sensors.joints())
            elif (torque := motors.arrived(self._steps)) is not None:
                data.ctrl[:] = torque
            self._pushes.apply(self._steps, mujoco, model, data)
            # mj_step's two halves, turned round: the tick ends with fresh kinematics.
            mujoco.mj_step2(model, data)
            self._sensors.accumulate()
            mujoco.mj_step1(model, data)
            self._steps += 1
        velocity = data.qvel
        # A NaN makes the comparison false.
        if not velocity.dot(velocity) < _MAX_SPEED**2:
            raise PhysicsDiverged(self._divergence())
        self._sensors.update()
        if servos is not None:
            servos.add_play(self._sensors.reading)
        self._delay.add(self._sensors.reading)
        self._measurement = None

    def _divergence(self) -> str:
        """Return a message that names the fastest coordinate."""
        velocity = self.ground_truth().v
        broken = np.flatnonzero(~np.isfinite(velocity))
        fastest = int(broken[0]) if broken.size else int(np.argmax(np.abs(velocity)))
        what = "the base" if fastest < 6 else f"joint '{self.robot.joint_names[fastest - 6]}'"
        unit = "m/s" if fastest < 3 else "rad/s (m/s if prismatic)" if fastest >= 6 else "rad/s"
        return (
            f"the physics diverged at {self.time:.3f} s: {what} moves at "
            f"{velocity[fastest]:.3g} {unit}; a smaller timestep than {self.timestep} s or a "
            "larger joint armature helps"
        )

    def push(self, impulse: Any, *, duration: float = 0.1, frame: str | None = None) -> None:
        """Push now: see `schedule_push`."""
        self.schedule_push(self.time, impulse, duration=duration, frame=frame)

    def schedule_push(
        self, at_time: float, impulse: Any, *, duration: float = 0.1, frame: str | None = None
    ) -> None:
        """Schedule a constant force that delivers an impulse, F = impulse / duration.

        Args:
            at_time: time at which it begins, s; not before the present time.
            impulse: (3,) world axes, N·s.
            duration: rounded to whole physics steps, s; the impulse stays exact.
            frame: the force acts at this frame's origin; by default at the centre of mass of
                the body that carries the robot's torso.

        Raises:
            PlantError: a shape, a duration or a time that makes no sense.
            FrameNotFound: the model has no such frame.
        """
        if not (np.isfinite(at_time) and at_time > self.time - 0.5 * self.timestep):
            raise PlantError(f"a push at {at_time} s: the time is {self.time:.3f} s already")
        body, point = self._push_point(frame)
        self._pushes.add(
            Push.of_impulse(impulse, at_time, duration, self.timestep, body=body, point=point)
        )

    def schedule_payload(self, at_time: float, mass: float, frame: str) -> None:
        """Schedule a ball that is fixed to the robot from a time on, at most until the next reset.

        No sensor and no model of a controller tells of it but by its weight.

        Args:
            at_time: s; rounded to control periods.
            mass: kg; 0 takes the payloads on that body off.
            frame: the ball's centre is at this frame's origin.

        Raises:
            PlantError: a mass or a time that makes no sense.
            FrameNotFound: the model has no such frame.
        """
        if not (np.isfinite(at_time) and at_time > self.time - 0.5 * self.timestep):
            raise PlantError(f"a payload at {at_time} s: the time is {self.time:.3f} s already")
        body, point = self._push_point(frame)
        self._payloads.add(Payload(at_time, mass, body, point))

    def pull(self, link: str, point: Any, target: Any) -> None:
        """Pull a point of a link towards a fixed point by a spring, until `release`.

        The spring reaches the robot's weight at half a metre, and is limited to half the weight.

        Args:
            link: name of a frame.
            point: (3,) attached point in axes of that frame, m.
            target: (3,) world axes, m.

        Raises:
            PlantError: a point that is not three finite numbers.
            FrameNotFound: the model has no such frame.
        """
        places = [np.asarray(place, dtype=float) for place in (point, target)]
        if not all(place.shape == (3,) and np.isfinite(place).all() for place in places):
            raise PlantError(f"a pull from {point!r} to {target!r} m: give three finite numbers")
        placed = self.robot.model.frames[self.robot.frame_id(link)]
        stiffness = self.robot.weight / _PULL_LENGTH
        self._pushes.pull = Pull(
            self.model.body(self.robot.model.names[placed.parentJoint]).id,
            placed.placement.act(places[0]),
            places[1],
            stiffness,
            2.0 * _PULL_DAMPING * math.sqrt(stiffness * self.robot.mass),
            _PULL_SHARE * self.robot.weight,
        )

    def release(self) -> None:
        """End the pull, if there is one."""
        self._pushes.pull = None

    def kick(self, velocity: Any) -> None:
        """Add a velocity to the whole robot at once, as learned policies are trained with.

        No sensor reads the jump itself: the accelerometer goes on as if it had not happened.

        Args:
            velocity: (3,) added to the base, and so to every link; world axes, m/s.

        Raises:
            PlantError: a wrong shape, or a number that is not finite.
        """
        added = np.asarray(velocity, dtype=float)
        if added.shape != (3,) or not np.isfinite(added).all():
            raise PlantError(f"a kick of {velocity!r} m/s must be three finite numbers")
        self.data.qvel[:3] += added
        self._mujoco.mj_step1(self.model, self.data)
        self._sensors.update()
        self._measurement = None

    def schedule_sensor_freeze(self, at_time: float, duration: float) -> None:
        """Schedule a time in which the sensors repeat their last reading, noise included.

        Args:
            at_time: time of the first repeated reading, s; after the first measurement.
            duration: s; one control period repeats one reading.

        Raises:
            PlantError: a time that is past, or a duration that is not positive.
        """
        if not (np.isfinite(at_time) and at_time > max(self.time, 0.5 * self.timestep)):
            raise PlantError(f"a freeze at {at_time} s: the time is {self.time:.3f} s already")
        if not (np.isfinite(duration) and duration > 0.0):
            raise PlantError(f"a freeze of {duration} s: the duration must be positive")
        margin = 0.5 * self.timestep  # times are sums of timesteps, up to rounding
        self._delay.freeze(at_time - margin, at_time + duration - margin)

    def ground_truth(self) -> State:
        """Return the exact state now: for reports and tests, not for controllers."""
        return self.coordinates.to_state(self.data.qpos, self.data.qvel)

    @property
    def torque(self) -> np.ndarray:
        """Torques that the motors exert now, (na,), N·m."""
        torque: np.ndarray = self.data.ctrl.copy()
        return torque

    @property
    def cart_position(self) -> float:
        """How far the cart has moved since the reset, m; 0 without one."""
        return 0.0 if self._cart is None else float(self.data.qpos[self._cart])

    @property
    def foot_forces(self) -> dict[str, np.ndarray]:
        """Sole name -> (6,) exact contact wrench of the last tick, in sole axes; N, N·m."""
        return {name: self._sensors.reading[at].copy() for name, at in self._wrench_slices}

    @property
    def push_force(self) -> np.ndarray:
        """Sum of the pushes that act now, (3,), world axes, N."""
        return self._pushes.force(self._steps)

    def contacts(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return (point, force on the robot) of each contact, world axes; m, N.

        It computes the contact forces anew on a copy of the state: not for the loop.
        """
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
            if first == second or root not in (first, second):
                continue
            # The contact's normal points from geom 1 to geom 2, and so does its force.
            sign = 1.0 if second == root else -1.0
            force = sign * (wrench[:3] @ contact.frame.reshape(3, 3))
            found.append((contact.pos.copy(), force))
        return found

    def self_contacts(self) -> list[tuple[str, str]]:
        """Return the pairs of bodies that touch each other now, by the names of their joints."""
        names = self.model.body
        return sorted(
            (names(first).name, names(second).name)
            for first, second in touching_bodies(self.model, self.data)
        )

    def _place_ground(self, state: State) -> None:
        """Place the terrain's origin where the robot that stands there was moved from."""
        yaw = heading(self.robot, state)
        c, s = math.cos(yaw), math.sin(yaw)
        x, y = self.robot.q_nominal[:2].tolist()
        at = state.q[0] - (c * x - s * y), state.q[1] - (s * x + c * y)
        self._ground.place(self.data, float(at[0]), float(at[1]), yaw)
        if self._cart is not None:
            base = self.model.body("cart_base").mocapid[0]
            self.data.mocap_pos[base] = [at[0], at[1], 0.0]
            self.data.mocap_quat[base] = [math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw)]

    def _push_point(self, frame: str | None) -> tuple[int, np.ndarray]:
        """Return MuJoCo's body id and the point of application in its axes, m."""
        name = self.robot.torso if frame is None else frame
        placed = self.robot.model.frames[self.robot.frame_id(name)]
        body = self.model.body(self.robot.model.names[placed.parentJoint]).id
        if frame is None:
            return body, self.model.body_ipos[body].copy()
        return body, placed.placement.translation.copy()


def _whole_steps(name: str, value: float, timestep: float, least: int) -> int:
    """Return how many physics steps a time is.

    Raises:
        PlantError: the timestep is not positive, or the time not a multiple of it.
    """
    if not (math.isfinite(timestep) and timestep > 0.0):
        raise PlantError(f"timestep = {timestep} s must be positive and finite")
    steps = round(value / timestep) if math.isfinite(value) else -1
    if steps < least or abs(steps * timestep - value) > 1e-9:
        raise PlantError(
            f"{name} = {value} s must be a whole number of timesteps of {timestep} s, "
            f"at least {least}"
        )
    return steps
