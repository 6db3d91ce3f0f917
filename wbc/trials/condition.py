"""Conditions of a trial: in what the plant differs from what the controller believes."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import pinocchio as pin

from wbc.errors import PlantError
from wbc.estimation import Estimator, GroundTruthEstimator
from wbc.robot import Robot
from wbc.robot.upper_body import UpperBody
from wbc.runtime.protocols import StateEstimator
from wbc.sim import Flat, Mujoco, Ramp, SensorNoise, SlipperyPatch, Terrain, Tiles
from wbc.trials.contact_by_time import ContactByTime
from wbc.trials.errors import TrialError

#: Each of these lays something on the floor.
_TERRAINS = ("tiles", "slope", "patch_friction")
_AT_LEAST_0 = (
    *_TERRAINS,
    "noise",
    "latency",
    "sensor_latency",
    "friction",
    "payload",
    "joint_friction",
    "joint_damping",
    "ground_sink",
)


@dataclass(frozen=True)
class Condition:
    """In what plant and sensors differ from what the controller and the estimator believe.

    Controller and estimator always have the nominal robot.

    Attributes:
        name: its name in results.
        noise: factor on all sensor noise.
        latency: age of a command when it reaches the motors, s.
        sensor_latency: age of the readings when they are measured, a multiple of 2 ms, s.
        friction: Coulomb coefficient between soles and ground.
        payload: mass that is carried, kg.
        payload_on: where it is: at the centre of mass of the torso, or half of it in each hand.
        mass: factor on mass and inertia of every link.
        com_offset: (x, y, z) by which the centre of mass of the whole robot is off, m, in the
            axes of the nominal posture; the torso's is moved.
        joint_friction: Coulomb friction of each joint, as a share of its torque limit.
        joint_damping: viscous friction of each joint, share of its torque limit per rad/s.
        torque_limits: factor on the torque limits of the motors.
        tiles: greatest height of square tiles on the floor, m; 0 for a flat floor. The seed of the
            trial draws their heights.
        slope: angle of a ramp of 2 m half a metre in front of the robot, with a plateau and a
            ramp down behind it, degrees; 0 for none.
        patch_friction: Coulomb coefficient of a patch of 2 m half a metre in front of the robot;
            0 for none.
        ground_sink: depth to which the standing robot sinks into soft ground, m; 0 for hard ground.
        state: "estimated" from noisy sensors, or "exact".
        foot_sensors: the soles have force sensors; without them the joints' torques are measured.
        contact: what the controller is given: contacts and foot loads as "measured", or nothing,
            so that contact goes by "time".

    Raises:
        TrialError: a value out of its range.
    """

    name: str = "nominal"
    noise: float = 1.0
    latency: float = 0.0
    sensor_latency: float = 0.0
    friction: float = 0.8
    payload: float = 0.0
    payload_on: Literal["torso", "hands"] = "torso"
    mass: float = 1.0
    com_offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    joint_friction: float = 0.0
    joint_damping: float = 0.0
    torque_limits: float = 1.0
    tiles: float = 0.0
    slope: float = 0.0
    patch_friction: float = 0.0
    ground_sink: float = 0.0
    foot_sensors: bool = True
    state: Literal["estimated", "exact"] = "estimated"
    contact: Literal["measured", "time"] = "measured"

    def __post_init__(self) -> None:
        for name in _AT_LEAST_0:
            self._check(name, least=0.0)
        for name in ("mass", "torque_limits"):
            self._check(name, above=0.0)
        terrains = [name for name in _TERRAINS if getattr(self, name) > 0.0]
        if len(terrains) > 1:
            raise TrialError(
                f"condition '{self.name}': {' and '.join(terrains)} exclude each other"
            )
        if not all(math.isfinite(x) for x in self.com_offset):
            raise TrialError(f"com_offset = {self.com_offset} must be three finite numbers, m")

    def _check(self, name: str, least: float = -math.inf, above: float = -math.inf) -> None:
        value = getattr(self, name)
        if not (math.isfinite(value) and value >= least and value > above):
            what = "positive" if above == 0.0 else "at least 0"
            raise TrialError(f"condition '{self.name}': {name} = {value} must be {what}")

    def alter(self, robot: Robot) -> Robot:
        """Return the robot as it is in this condition.

        Raises:
            TrialError: a payload in the hands of a robot without any.
        """
        nominal = (1.0, 1.0, 0.0, (0.0, 0.0, 0.0))
        if (self.mass, self.torque_limits, self.payload, tuple(self.com_offset)) == nominal:
            return robot
        model = robot.model.copy()
        model.effortLimit = self.torque_limits * np.array(model.effortLimit)
        for i in range(1, model.njoints):
            inertia = model.inertias[i]
            model.inertias[i] = pin.Inertia(
                self.mass * inertia.mass, inertia.lever, self.mass * inertia.inertia
            )
        torso = model.frames[robot.frame_id(robot.torso)].parentJoint
        if any(self.com_offset):
            data = model.createData()
            pin.forwardKinematics(model, data, robot.q_nominal)
            total = pin.computeTotalMass(model)
            inertia = model.inertias[torso]
            offset = data.oMi[torso].rotation.T @ np.array(self.com_offset)
            inertia.lever = inertia.lever + offset * (total / inertia.mass)
            model.inertias[torso] = inertia
        for joint, lever, share in self._payload_places(robot, model, torso):
            load = pin.Inertia(share * self.payload, lever, np.zeros((3, 3)))
            model.inertias[joint] = model.inertias[joint] + load
        return replace(robot, model=model)

    def _payload_places(
        self, robot: Robot, model: pin.Model, torso: int
    ) -> list[tuple[int, np.ndarray, float]]:
        """Return joint, place in its axes, m, and share of each part of the payload."""
        if self.payload == 0.0:
            return []
        if self.payload_on == "torso":
            return [(torso, model.inertias[torso].lever, 1.0)]
        arms = UpperBody.of(robot).arms
        if not arms:
            raise TrialError(
                f"condition '{self.name}': '{robot.name}' has no arms; give payload_on = 'torso'"
            )
        frames = [model.frames[robot.frame_id(arm.hand)] for arm in arms]
        return [(f.parentJoint, f.placement.translation, 1.0 / len(arms)) for f in frames]

    def make_plant(self, robot: Robot, dt: float, seed: int) -> Mujoco:
        """Return the simulated robot.

        Args:
            robot: the nominal robot.
            dt: control period, s.
            seed: seed of sensor noise and terrain.

        Raises:
            TrialError: MuJoCo cannot represent it.
        """
        altered = self.alter(robot)
        try:
            plant = Mujoco(
                altered,
                dt=dt,
                friction=self.friction,
                terrain=self._terrain(seed),
                noise=SensorNoise().scaled(self.noise),
                ground_truth=self.state == "exact",
                seed=seed,
                latency=self.latency,
                sensor_latency=self.sensor_latency,
                ground_sink=self.ground_sink,
                foot_sensors=self.foot_sensors,
            )
        except PlantError as error:
            raise TrialError(f"condition '{self.name}' of '{robot.name}': {error}") from error
        for name, limit in zip(robot.joint_names, robot.tau_max, strict=True):
            dof = plant.model.joint(name).dofadr[0]
            plant.model.dof_frictionloss[dof] = self.joint_friction * limit
            plant.model.dof_damping[dof] = self.joint_damping * limit
        return plant

    def _terrain(self, seed: int) -> Terrain:
        if self.tiles > 0.0:
            return Tiles(height=self.tiles, seed=seed)
        if self.patch_friction > 0.0:
            return SlipperyPatch(self.patch_friction)
        return Ramp(math.radians(self.slope)) if self.slope > 0.0 else Flat()

    def make_estimator(self, robot: Robot, dt: float) -> StateEstimator:
        """Return the estimator of the state.

        Args:
            robot: the nominal robot.
            dt: control period, s.
        """
        exact = self.state == "exact"
        estimator = GroundTruthEstimator(robot) if exact else Estimator(robot, dt)
        return estimator if self.contact == "measured" else ContactByTime(estimator)
