"""A learned policy behind the protocol of controllers."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from wbc.command import Command, Status
from wbc.errors import GaitError, JointNotFound
from wbc.estimation import Estimate
from wbc.robot import Robot
from wbc.state import State
from wbc.trials.policy.description import PolicyDescription
from wbc.trials.policy.errors import PolicyError
from wbc.trials.policy.network import PolicyNetwork
from wbc.trials.policy.observation import ObservationHistory, PolicyInputs
from wbc.walking import VelocityClamped

#: Where a policy's files are, seen from its folder; unitree_rl_lab has folders of their own.
_DESCRIPTIONS = ("deploy.yaml", "params/deploy.yaml")
_NETWORKS = ("policy.onnx", "exported/policy.onnx")

_GAIT_CYCLE = 0.8  # s, which is usual for policies of humanoids


class PolicyController:
    """Walks by a learned policy: joint targets from a network, torques from a PD law.

    Every `description.period` the network maps the observation o to an action a. In each tick

        τ = kp (q* − q) − kd q̇,    q* = clip(scale · a + offset),

    within the robot's torque limits. The network reads the estimate only: what it observes is
    what a robot measures.

    Copies and pickles go on bit-identically.

    Args:
        robot: the robot.
        description: how the network is driven.
        network: the network.
        dt: control period, of which the policy's period is a multiple, s.

    Attributes:
        robot: the robot.
        dt: control period, s.
        description: how the network is driven.
        network: the network.

    Raises:
        PolicyError: description, network and robot do not fit each other, or the periods.
        JointNotFound: the robot lacks one of the policy's joints.
    """

    def __init__(
        self,
        robot: Robot,
        description: PolicyDescription,
        network: PolicyNetwork,
        dt: float = 0.002,
    ) -> None:
        self.robot = robot
        self.dt = dt
        self.description = description
        self.network = network
        self._every = round(description.period / dt)
        if self._every < 1 or abs(self._every * dt - description.period) > 1e-9:
            raise PolicyError(
                f"the policy's period of {description.period} s is no multiple of the control "
                f"period, {dt} s"
            )
        self._joints = _joint_indices(robot, description)
        joints = len(self._joints)
        self._history = ObservationHistory(description.terms, joints)
        if (network.inputs, network.outputs) != (self._history.size, joints):
            raise PolicyError(
                f"{network!r} does not fit its description, by which it has "
                f"{self._history.size} inputs and {joints} outputs: compare observations, "
                "history lengths and joints"
            )
        self._kp, self._kd = np.zeros((2, robot.na))
        self._kp[self._joints] = description.stiffness
        self._kd[self._joints] = description.damping
        self._velocity = np.zeros(3)
        self.reset(robot.standing())

    def __repr__(self) -> str:
        return f"PolicyController({self.robot.name}, {self.network!r}, dt={self.dt} s)"

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Wanted velocity: forward, left, m/s, turn left, rad/s; may be set at any tick.

        Beyond what the policy was trained for it is clamped, with a `VelocityClamped` warning.

        Raises:
            GaitError: it is not three finite numbers.
        """
        forward, left, turn = self._velocity.tolist()
        return (forward, left, turn)

    @velocity.setter
    def velocity(self, value: Sequence[float]) -> None:
        wanted = np.array(value, dtype=float)
        if wanted.shape != (3,) or not np.isfinite(wanted).all():
            raise GaitError(
                f"velocity = {value!r}: give three finite numbers: forward and left, m/s, and "
                "turn, rad/s"
            )
        low, high = np.array(self.description.velocity_limits).T
        self._velocity = np.clip(wanted, low, high)
        if (self._velocity != wanted).any():
            warnings.warn(
                f"velocity {tuple(wanted.tolist())} is beyond what the policy was trained for: "
                f"clamped to {self.velocity} (m/s, m/s, rad/s)",
                VelocityClamped,
                stacklevel=2,
            )

    @property
    def joint_targets(self) -> np.ndarray:
        """Joint positions q* that it asks for now, (na,), rad."""
        return self._target.copy()

    @property
    def gait_cycle(self) -> float:
        """Time over which disturbances are spread, s; a network does not tell its steps."""
        return _GAIT_CYCLE

    def reset(self, state: State) -> None:
        """Start anew: the network is evaluated in the next tick, with no memory.

        What is wanted of it stays: the velocity.

        Raises:
            StateError: see `State.validated`.
        """
        state.validated(self.robot.model)
        self._history.clear()
        self._tick = 0
        self._action = np.zeros(len(self._joints))
        self._target = np.zeros(self.robot.na)
        self._target[self._joints] = self.description.action_offset

    def step(self, estimate: Estimate) -> Command:
        """One tick.

        Raises:
            StateError: see `State.validated`.
        """
        state, robot = estimate.state, self.robot
        if not state.is_valid(robot.nq, robot.nv):
            state = state.validated(robot.model)
        if self._tick % self._every == 0:
            self._evaluate(state)
        self._tick += 1
        q, v = state.q[7:], state.v[6:]
        tau = self._kp * (self._target - q) - self._kd * v
        status, explanation = Status.OK, ""
        if not math.isfinite(self._action.dot(self._action)):
            tau = -self._kd * v
            status, explanation = Status.FAILED, "the output of the policy's network is not finite"
        limit = robot.tau_max
        return Command(
            np.minimum(np.maximum(tau, -limit), limit),
            np.zeros(robot.nv),
            {},
            q + self.dt * v,
            v.copy(),
            status,
            explanation,
        )

    def _evaluate(self, state: State) -> None:
        """Compute action and joint targets from the observation of now."""
        description, joints = self.description, self._joints
        inputs = PolicyInputs(
            state.v[:6],
            state.q[3:7],
            self._velocity,
            state.q[7:][joints],
            state.v[6:][joints],
            description.default,
            self._action,
            self._tick * self.dt,
        )
        self._action = self.network(self._history.update(inputs)).astype(float)
        target = description.action_scale * self._action + description.action_offset
        low, high = description.action_limits.T
        self._target[joints] = np.minimum(np.maximum(target, low), high)


def load_policy(robot: Robot, dt: float = 0.002, *, folder: Path | str) -> PolicyController:
    """Return the controller of a policy in a folder; a `ControllerFactory` with its folder bound.

    Args:
        robot: the robot.
        dt: control period, s.
        folder: folder with `deploy.yaml` and `policy.onnx`, or with these as
            `params/deploy.yaml` and `exported/policy.onnx`.

    Raises:
        PolicyError: a file is missing, cannot be read or does not fit the others or the robot.
        JointNotFound: the robot lacks one of the policy's joints.
        MissingExtra: `onnxruntime` or PyYAML is not installed.
    """
    description, network = policy_files(folder)
    return PolicyController(
        robot, PolicyDescription.load(description), PolicyNetwork.load(network), dt
    )


def policy_files(folder: Path | str) -> tuple[Path, Path]:
    """Return the files of a policy in a folder: its description and its network.

    Args:
        folder: see `load_policy`.

    Raises:
        PolicyError: one is missing.
    """
    folder = Path(folder).expanduser()
    return _find(folder, _DESCRIPTIONS), _find(folder, _NETWORKS)


def _find(folder: Path, places: Sequence[str]) -> Path:
    for place in places:
        if (folder / place).is_file():
            return folder / place
    raise PolicyError(
        f"the policy's folder '{folder}' has no {' nor '.join(places)}: give a folder that holds "
        "a network and its description"
    )


def _joint_indices(robot: Robot, description: PolicyDescription) -> np.ndarray:
    """Return the robot's index of each joint of the network.

    Raises:
        PolicyError: there are joints that the policy does not command.
        JointNotFound: the robot lacks one.
    """
    names = description.joint_names or robot.joint_names
    for name in names:
        if name not in robot.joint_names:
            raise JointNotFound(name, robot.joint_names, "the policy's joint_names")
    missing = [name for name in robot.joint_names if name not in names]
    if missing or len(names) != len(description.motors):
        raise PolicyError(
            f"the policy commands {len(description.motors)} joints and {robot.name} has "
            f"{robot.na}: it is made for another robot"
            + (f" (nobody commands {', '.join(missing[:6])})" if missing else "")
        )
    return np.array([robot.joint_index(names[motor]) for motor in description.motors], dtype=int)
