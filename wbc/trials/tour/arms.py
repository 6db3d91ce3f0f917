"""Arms that somebody else moves: a random walk of their joints, outside of the controller."""

from __future__ import annotations

import copy
import math
from dataclasses import replace

import numpy as np
import pinocchio as pin

from wbc.command import Command
from wbc.errors import PlantError
from wbc.estimation import Estimate
from wbc.limits import AnyLimit, JointPositionLimit, JointVelocityLimit, TorqueLimit
from wbc.robot import Robot
from wbc.robot.upper_body import UpperBody
from wbc.runtime.protocols import Plant, VelocityController
from wbc.state import State
from wbc.tasks import JointTorqueTask
from wbc.trials.policy import PolicyController
from wbc.trials.tour.schedule import ARMS
from wbc.walking import Walker

_WINDOW = 0.5  # s between two targets
_STEP = 0.06  # rad, largest step of the random walk
_STEPS = 25  # of the random walk within a window
_DRAWS = 8  # of a target, before the last one is kept
_NECK = 0.1  # share of the arms' height above the shoulders up to which hands may rise
_FREE = 1e4  # rad, rad/s, N·m: beyond what any arm reaches
_OBSERVER_TIME = 0.05  # s, of the disturbance of the arms
_FREQUENCY, _DAMPING = 2.0 * math.pi * 10.0, 2.0  # of the motors alone: rad/s, ratio


class ArmMotion:
    """Joint targets of both arms: a random walk, the right arm the mirror image of the left.

    Every 0.5 s a new target is drawn, 25 steps of up to ±0.06 rad in each joint away from the last
    one, within the joint limits; between two targets the joints move linearly. A target that puts
    a hand behind its place in the standing posture, or above the shoulders, is drawn again, up to
    eight times.

    Args:
        robot: the robot.
        seed: seed of the tour.

    Attributes:
        joints: (k,) indices of the arms' joints into (na,) vectors, left arm first.
        stiffness: (k,) gain of the arms' motors, N·m/rad.
        damping: (k,) gain of the arms' motors, N·m·s/rad.

    Raises:
        MotionError: the robot lacks an arm.
        PlantError: its arms are no mirror images of each other.
    """

    def __init__(self, robot: Robot, seed: int) -> None:
        self._model, self._data = robot.model, robot.model.createData()
        left, right = UpperBody.of(robot).both_arms()
        self.joints = np.array(left.joints + right.joints, dtype=int)
        self._mirror = _mirror_signs(robot, np.array(left.joints), np.array(right.joints))
        inertia = robot.model.armature[6 + self.joints]
        self.stiffness = inertia * _FREQUENCY**2
        self.damping = 2.0 * _DAMPING * inertia * _FREQUENCY
        self._hands = [robot.frame_id(arm.hand) for arm in (left, right)]
        self._shoulders = [robot.model.getJointId(arm.shoulder) for arm in (left, right)]
        self._trunk = robot.frame_id(robot.torso)
        self._rise = _NECK * left.length
        lower, upper = robot.q_min[self.joints], robot.q_max[self.joints]
        n = len(left.joints)
        mirrored = np.sort(self._mirror * np.array((lower[n:], upper[n:])), axis=0)
        self._lower = np.maximum(lower[:n], mirrored[0])
        self._upper = np.minimum(upper[:n], mirrored[1])
        self._rng = np.random.default_rng((seed, ARMS))
        self._q = robot.q_nominal.copy()
        start = self._q[7 + np.array(left.joints)]
        self._from, self._to = start, start
        self._front = self._foremost(start)
        self._window = -1

    def _both(self, left: np.ndarray) -> np.ndarray:
        return np.concatenate((left, self._mirror * left))

    def targets(self, time: float) -> np.ndarray:
        """Return the joint positions (k,) at a time since the start, rad; times only increase."""
        window = int(time / _WINDOW)
        while self._window < window:
            self._window += 1
            self._from, self._to = self._to, self._draw(self._to)
        share = time / _WINDOW - self._window
        return self._both(self._from + share * (self._to - self._from))

    def _draw(self, start: np.ndarray) -> np.ndarray:
        """Return a new target of the left arm; the old one if eight in a row are refused."""
        for _ in range(_DRAWS):
            target = start
            for step in self._rng.uniform(-_STEP, _STEP, (_STEPS, start.size)):
                target = np.minimum(np.maximum(target + step, self._lower), self._upper)
            if self._foremost(target) >= self._front and self._below_the_neck():
                return target
        return start

    def _foremost(self, left: np.ndarray) -> float:
        """Return how far the rear hand is in front of the torso, m; updates the kinematics."""
        self._q[7 + self.joints] = self._both(left)
        pin.forwardKinematics(self._model, self._data, self._q)
        pin.updateFramePlacements(self._model, self._data)
        trunk = self._data.oMf[self._trunk]
        return min(float(trunk.actInv(self._data.oMf[hand].translation)[0]) for hand in self._hands)

    def _below_the_neck(self) -> bool:
        data = self._data
        return all(
            data.oMf[hand].translation[2] <= data.oMi[shoulder].translation[2] + self._rise
            for hand, shoulder in zip(self._hands, self._shoulders, strict=True)
        )


class TourController:
    """A controller whose arms are moved by somebody else.

    The arms' torques of each command are replaced by those of a PD law on the arms' targets,
    within the torque limits; legs, waist and head stay with the controller. A `Walker` is told
    the targets, as those of the public benchmark are, and takes its arms as given: it does not
    move them to keep its balance. A `PolicyController` is shown arms that obey it, as there: the
    positions that it asks for, at rest.

    Args:
        controller: the controller.
        arms: the motion of the arms.
        plant: the robot that is controlled.

    Attributes:
        controller: the controller.
        dt: its control period, s.
        time: time since the start of the arms' motion, s; set before each tick.
    """

    def __init__(self, controller: VelocityController, arms: ArmMotion, plant: Plant) -> None:
        self.controller = controller
        self.dt = plant.dt
        self.time = 0.0
        self._arms = arms
        self._limits = plant.robot.tau_max[arms.joints]
        self._velocity: np.ndarray | None = None
        self._expected = np.zeros(arms.joints.size)
        self._task: JointTorqueTask | None = None
        if isinstance(controller, Walker):
            self._task = _yield_arms(controller, arms)

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Wanted velocity: forward and left, m/s, and turn to the left, rad/s."""
        return self.controller.velocity

    @velocity.setter
    def velocity(self, value: tuple[float, float, float]) -> None:
        self.controller.velocity = value

    def reset(self, state: State) -> None:
        """See `wbc.runtime.protocols.Controller`."""
        self.controller.reset(state)
        self._velocity = None
        if self._task is not None:
            self._task.disturbance[:] = 0.0

    def step(self, estimate: Estimate) -> Command:
        """See `wbc.runtime.protocols.Controller`."""
        arms = self._arms
        q, v = estimate.state.q[7:][arms.joints], estimate.state.v[6:][arms.joints]
        torque = arms.stiffness * (arms.targets(self.time) - q) - arms.damping * v
        torque = np.minimum(np.maximum(torque, -self._limits), self._limits)
        if self._task is not None:
            self._observe(v)
            self._task.target[:] = torque
        command = self.controller.step(self._shown(estimate))
        self._expected = command.acceleration[6 + arms.joints]
        tau = command.tau.copy()
        tau[arms.joints] = torque
        return replace(command, tau=tau)

    def _shown(self, estimate: Estimate) -> Estimate:
        """Return the estimate that the controller gets."""
        if not isinstance(self.controller, PolicyController):
            return estimate
        q, v, joints = estimate.state.q.copy(), estimate.state.v.copy(), self._arms.joints
        q[7 + joints], v[6 + joints] = self.controller.joint_targets[joints], 0.0
        return replace(estimate, state=State(q, v))

    def _observe(self, velocity: np.ndarray) -> None:
        """Update what the arms' accelerations have beyond what was expected of them."""
        assert self._task is not None
        if self._velocity is not None:
            surprise = (velocity - self._velocity) / self.dt - self._expected
            self._task.disturbance += self.dt / _OBSERVER_TIME * surprise
        self._velocity = velocity


def _yield_arms(walker: Walker, arms: ArmMotion) -> JointTorqueTask:
    """Take the arms out of a walker's posture and limits; return the task that knows their torques.

    A limit of the QP would contradict what the arms really do, for instance at a joint's stop. The
    task is exact: as a cost, it would give way under a punch, and the QP would count on arms that
    catch it.
    """
    joints, robot, controller = arms.joints, walker.robot, walker.controller
    weight = walker.posture.weight.copy()
    weight[joints] = 0.0
    walker.posture.weight = weight
    controller.set_limits([_without(limit, joints, robot) for limit in controller.limits])
    names = [robot.joint_names[joint] for joint in joints]
    return controller.add(JointTorqueTask(robot, names, priority=0))


def _without(limit: AnyLimit, joints: np.ndarray, robot: Robot) -> AnyLimit:
    """Return a limit that leaves some joints free."""

    def freed(values: np.ndarray, value: float) -> np.ndarray:
        values = values.copy()
        values[joints] = value
        return values

    if isinstance(limit, TorqueLimit):
        return TorqueLimit(robot, freed(limit.maximum, _FREE))
    if isinstance(limit, JointVelocityLimit):
        maximum = freed(limit.maximum, _FREE)
        return JointVelocityLimit(robot, maximum, horizon=limit.horizon, braking=limit.braking)
    if isinstance(limit, JointPositionLimit):
        limit = copy.copy(limit)
        limit.lower, limit.upper = freed(limit.lower, -_FREE), freed(limit.upper, _FREE)
    return limit


def _mirror_signs(robot: Robot, left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return the sign that makes each joint of the right arm the mirror image of the left one.

    Raises:
        PlantError: the arms are no mirror images of each other.
    """
    model, data = robot.model, robot.model.createData()
    q = robot.q_nominal.copy()
    q[7:] = 0.0
    J = pin.computeJointJacobians(model, data, q)
    if left.size == right.size:
        reflected = J[3:, 6 + left] * np.array(((-1.0,), (1.0,), (-1.0,)))
        cosine = np.einsum("ij,ij->j", reflected, J[3:, 6 + right])
        if (np.abs(cosine) > 0.9).all():
            signs: np.ndarray = np.sign(cosine)
            return signs
    raise PlantError(
        f"the arms of {robot.name} are no mirror images of each other: the tour moves both alike"
    )
