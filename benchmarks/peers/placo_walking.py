"""placo's walk as a controller in closed loop: pattern generator, inverse kinematics, joint PD.

    PYTHONPATH=benchmarks wbc trials benchmarks/grids/peers.toml

placo plans footsteps, ZMP and CoM (its preview QP) for one velocity, its `KinematicsSolver` turns
the plan into joint positions, and a PD law holds the joints there. Nothing looks at the estimate
but the PD law: this is what the library offers by itself.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import placo

import wbc
from peers.robot_file import urdf_text
from wbc.errors import GaitError

STIFFNESS, DAMPING = 20.0, 0.6  # of each joint, as multiples of its torque limit: 1/rad, s/rad
BLEND = 0.5  # s from the standing posture to the beginning of the plan
DURATION = 20.0  # s of walking that are planned; afterwards the robot stands
SETTLE = 40  # solutions of the inverse kinematics before the plan begins
COM_LOWERED = 0.02  # m below the standing height, so that the knees do not lock
POSTURE_WEIGHT = 1e-3


class PlacoController:
    """Holds the joints on placo's plan, which is made anew whenever the velocity is set.

    Args:
        robot: the robot.
        dt: control period, s.

    Raises:
        GaitError: a velocity that is not straight forward or backward.
    """

    def __init__(self, robot: wbc.Robot, dt: float) -> None:
        self._robot = robot
        self.dt = dt
        self._gait = wbc.GaitParameters.for_robot(robot)
        self._speed = 0.0
        self.reset(robot.standing())

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Velocity of the plan: forward, m/s; nothing else is planned."""
        return (self._speed, 0.0, 0.0)

    @velocity.setter
    def velocity(self, value: Sequence[float]) -> None:
        forward, left, turn = value
        if left or turn:
            raise GaitError(f"velocity {tuple(value)}: placo's walk is planned straight ahead only")
        self._speed = float(forward)
        self._plan()

    @property
    def gait_cycle(self) -> float:
        """Duration of a step of each foot, s."""
        return 2.0 * self._gait.step_duration

    def reset(self, state: wbc.State) -> None:
        """Start anew, standing."""
        self._start = state.q.copy()
        self._plan()

    def step(self, estimate: wbc.Estimate) -> wbc.Command:
        """Return the torques of the PD law."""
        k = min(max(self._tick - self._blend, 0), len(self._positions) - 1)
        share = min(self._tick / self._blend, 1.0)
        self._tick += 1
        target = (1.0 - share) * self._start[7:] + share * self._positions[k]
        velocity = self._velocities[k] if share == 1.0 else np.zeros(self._robot.na)
        q, v, limit = estimate.state.q[7:], estimate.state.v[6:], self._robot.tau_max
        tau = limit * (STIFFNESS * (target - q) + DAMPING * (velocity - v))
        still = np.zeros(self._robot.nv)
        return wbc.Command(np.clip(tau, -limit, limit), still, {}, target, velocity)

    def _plan(self) -> None:
        """Compute the joint positions of the walk, (n, na)."""
        self._tick, self._blend = 0, round(BLEND / self.dt)
        self._positions = self._start[7:][None].copy()
        if self._speed:
            self._positions = _walk(self._robot, self._gait, self._start, self._speed, self.dt)
        self._velocities = np.zeros_like(self._positions)
        if len(self._positions) > 1:
            self._velocities = np.gradient(self._positions, self.dt, axis=0)


def _walk(
    robot: wbc.Robot, gait: wbc.GaitParameters, start: np.ndarray, speed: float, dt: float
) -> np.ndarray:
    """Return the joint positions of a straight walk, (n, na), one row per tick."""
    humanoid = _load(robot)
    humanoid.state.q = start.copy()
    humanoid.update_kinematics()
    parameters = _parameters(robot, gait, float(humanoid.com_world()[2]))
    solver = placo.KinematicsSolver(humanoid)
    solver.dt = dt
    solver.enable_velocity_limits(True)
    solver.enable_joint_limits(True)
    tasks = placo.WalkTasks()
    tasks.initialize_tasks(solver, humanoid)
    posture = solver.add_joints_task()
    posture.set_joints(dict(zip(robot.joint_names, map(float, start[7:]), strict=True)))
    posture.configure("posture", "soft", POSTURE_WEIGHT)
    planner = placo.FootstepsPlannerRepetitive(parameters)
    planner.configure(speed * gait.step_duration, 0.0, 0.0, round(DURATION / gait.step_duration))
    feet = (humanoid.get_T_world_left(), humanoid.get_T_world_right())
    footsteps = planner.plan(placo.HumanoidRobot_Side.left, *map(placo.flatten_on_floor, feet))
    supports = placo.FootstepsPlanner.make_supports(
        footsteps, 0.0, True, parameters.has_double_support(), True
    )
    generator = placo.WalkPatternGenerator(humanoid, parameters)
    trajectory = generator.plan(supports, humanoid.com_world(), 0.0)
    positions = []
    for tick in range(-SETTLE, int(trajectory.t_end / dt)):
        tasks.update_tasks_from_trajectory(trajectory, max(tick, 0) * dt)
        humanoid.update_kinematics()
        solver.solve(True)
        if tick >= 0:
            positions.append(np.array(humanoid.state.q[7:]))
    return np.array(positions)


def _load(robot: wbc.Robot) -> placo.HumanoidRobot:
    """Return placo's robot with the frames that its walk wants."""
    frames = {f"{sole.side}_foot": sole.frame_id for sole in robot.soles}
    frames["trunk"] = robot.frame_id(robot.torso)
    with tempfile.TemporaryDirectory(prefix="wbc-peer-") as folder:
        path = Path(folder) / "robot.urdf"
        path.write_text(urdf_text(robot.model, frames))
        return placo.HumanoidRobot(str(path), placo.Flags.ignore_collisions)


def _parameters(
    robot: wbc.Robot, gait: wbc.GaitParameters, com_height: float
) -> placo.HumanoidParameters:
    """Return placo's parameters for the timing and geometry of our gait."""
    sole = robot.soles[0]
    parameters = placo.HumanoidParameters()
    parameters.single_support_duration = gait.single_support
    parameters.single_support_timesteps = 10
    parameters.double_support_ratio = gait.double_support / gait.single_support
    parameters.startend_double_support_ratio = 2.0
    parameters.planned_timesteps = 48
    parameters.walk_com_height = com_height - COM_LOWERED
    parameters.walk_foot_height = gait.swing_height
    parameters.walk_trunk_pitch = 0.0
    parameters.walk_foot_rise_ratio = 0.2
    parameters.foot_length, parameters.foot_width = 2 * sole.half_length, 2 * sole.half_width
    parameters.feet_spacing = gait.step_width
    parameters.zmp_margin = 0.02
    parameters.foot_zmp_target_x = parameters.foot_zmp_target_y = 0.0
    parameters.walk_max_dx_forward = parameters.walk_max_dx_backward = gait.max_step
    parameters.walk_max_dy, parameters.walk_max_dtheta = gait.max_side_step, gait.max_turn
    return parameters
