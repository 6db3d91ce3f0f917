"""Adapter of placo's `KinematicsSolver`, which solves a smaller problem: velocities only."""

from __future__ import annotations

import tempfile
from importlib.metadata import version

import numpy as np
import placo

from peers.case import LEFT, RIGHT, SOLES, STANCES, TORSO, Case
from peers.measuring import Outcome

DT = 0.002


class PlacoIk:
    """Uses hard tasks for the standing feet, soft ones for CoM, torso, swing foot and posture."""

    def __init__(self, case: Case) -> None:
        self.versions = {name: version(name) for name in ("placo", "pin")}
        ticks, limits = case.ticks, case.limits
        with tempfile.TemporaryDirectory() as folder:
            flags = placo.Flags.ignore_collisions
            self._robot = robot = placo.RobotWrapper(folder, flags, case.urdf)
        for i, joint in enumerate(case.joints):
            robot.set_rotor_inertia(joint, case.armature[i])
            robot.set_gear_ratio(joint, 1.0)
            robot.set_velocity_limit(joint, limits.velocity[i])
            robot.set_joint_limits(joint, limits.lower[i], limits.upper[i])
        robot.state.q, robot.state.qd = ticks.q[0], ticks.v[0]
        robot.update_kinematics()
        case.check_model(robot.mass_matrix(), robot.non_linear_effects(), list(robot.joint_names()))
        self._stances = {s: self._formulate(case, s) for s in np.unique(ticks.stance)}
        self._per_tick = [self._stances[s] for s in ticks.stance]
        self._q, self._com, self._torso = list(ticks.q), list(ticks.com), list(ticks.torso)
        self._feet = [self._placements(q, s) for q, s in zip(ticks.q, ticks.stance, strict=True)]
        self._swing = list(ticks.swing)

    def _formulate(self, case: Case, stance: int) -> tuple[object, ...]:
        robot, gains, ticks = self._robot, case.gains, case.ticks
        k = int(np.flatnonzero(ticks.stance == stance)[0])
        robot.state.q = ticks.q[k]
        robot.update_kinematics()
        solver = placo.KinematicsSolver(robot)
        solver.dt = DT
        solver.enable_velocity_limits(True)
        solver.enable_joint_limits(True)
        feet = []
        for side in STANCES[stance]:
            foot = solver.add_frame_task(SOLES[side], robot.get_T_world_frame(SOLES[side]))
            foot.configure(side, "hard", 1.0, 1.0)
            feet.append(foot)
        com = solver.add_com_task(ticks.com[k])
        com.configure("com", "soft", gains.com_weight)
        torso = solver.add_orientation_task(TORSO, ticks.torso[k])
        torso.configure("torso", "soft", gains.torso_weight)
        posture = solver.add_joints_task()
        posture.set_joints(dict(zip(case.joints, map(float, ticks.posture), strict=True)))
        posture.configure("posture", "soft", gains.posture_weight)
        swing = None
        if stance in (LEFT, RIGHT):
            free = SOLES["right" if stance == LEFT else "left"]
            swing = solver.add_frame_task(free, ticks.swing[k])
            swing.configure("swing", "soft", gains.swing_weight, gains.swing_weight)
        return solver, feet, com, torso, swing

    def _placements(self, q: np.ndarray, stance: int) -> list[np.ndarray]:
        """Return the placements at which the standing feet are held."""
        self._robot.state.q = q
        self._robot.update_kinematics()
        return [np.array(self._robot.get_T_world_frame(SOLES[side])) for side in STANCES[stance]]

    def tick(self, k: int) -> np.ndarray:
        """See `Adapter`; a step of the configuration instead of torques."""
        solver, feet, com, torso, swing = self._per_tick[k]
        robot = self._robot
        robot.state.q = self._q[k]
        robot.update_kinematics()
        for foot, placement in zip(feet, self._feet[k], strict=True):
            foot.T_world_frame = placement
        com.target_world = self._com[k]
        torso.R_world_frame = self._torso[k]
        if swing is not None:
            swing.T_world_frame = self._swing[k]
        self._step = solver.solve(False)
        return self._step

    def outcome(self) -> Outcome:
        """See `Adapter`; there are no torques."""
        nv = len(self._step)
        ok = bool(np.isfinite(self._step).all())
        return Outcome(ok, np.full(nv - 6, np.nan), np.full(nv, np.nan), np.full((2, 6), np.nan))
