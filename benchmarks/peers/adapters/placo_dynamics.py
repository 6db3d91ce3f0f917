"""Adapter of placo's `DynamicsSolver`."""

from __future__ import annotations

import tempfile
from importlib.metadata import version

import numpy as np
import placo

from peers.case import LEFT, RIGHT, SOLES, STANCES, TORSO, Case
from peers.measuring import Outcome


class Placo:
    """Uses one solver for each set of standing feet; all share one robot."""

    def __init__(self, case: Case) -> None:
        self.versions = {name: version(name) for name in ("placo", "pin")}
        ticks, limits = case.ticks, case.limits
        self._joints = case.joints
        with tempfile.TemporaryDirectory() as folder:
            flags = placo.Flags.ignore_collisions
            self._robot = robot = placo.RobotWrapper(folder, flags, case.urdf)
        for i, joint in enumerate(case.joints):
            robot.set_rotor_inertia(joint, case.armature[i])
            robot.set_gear_ratio(joint, 1.0)
            robot.set_torque_limit(joint, limits.torque[i])
            robot.set_velocity_limit(joint, limits.velocity[i])
            robot.set_joint_limits(joint, limits.lower[i], limits.upper[i])
        self._show(ticks.q[0], ticks.v[0])
        case.check_model(robot.mass_matrix(), robot.non_linear_effects(), list(robot.joint_names()))
        self._stances = {s: self._formulate(case, s) for s in np.unique(ticks.stance)}
        self._per_tick = [self._stances[s] for s in ticks.stance]
        self._q, self._v = list(ticks.q), list(ticks.v)
        self._com, self._dcom = list(ticks.com), list(ticks.com_velocity)
        self._ddcom = list(ticks.com_acceleration)
        self._torso, self._omega = list(ticks.torso), list(ticks.torso_velocity)
        self._swing = list(ticks.swing)
        self._dswing, self._ddswing = ticks.swing_velocity, ticks.swing_acceleration

    def _show(self, q: np.ndarray, v: np.ndarray) -> None:
        state = self._robot.state
        state.q = q
        state.qd = v
        self._robot.update_kinematics()

    def _formulate(self, case: Case, stance: int) -> tuple[object, ...]:
        robot, gains, limits, ticks = self._robot, case.gains, case.limits, case.ticks
        k = int(np.flatnonzero(ticks.stance == stance)[0])
        self._show(ticks.q[k], ticks.v[k])
        solver = placo.DynamicsSolver(robot)
        solver.dt = limits.horizon  # used by the limits only
        solver.torque_cost = 0.0
        solver.problem.rewrite_equalities = False  # 5 % faster here than eliminating them
        solver.enable_torque_limits(True)
        solver.enable_velocity_limits(True)
        solver.enable_joint_limits(True)
        for joint, braking in zip(case.joints, limits.braking, strict=True):
            solver.set_qdd_safe(joint, braking)
        contacts = {}
        for side in STANCES[stance]:
            task = solver.add_frame_task(SOLES[side], robot.get_T_world_frame(SOLES[side]))
            task.configure(side, "hard", 1.0, 1.0)
            for part in (task.position(), task.orientation()):
                part.kp, part.kd = 0.0, gains.contact_damping
            contact = solver.add_planar_contact(task)
            contact.length, contact.width = 2.0 * case.half_length, 2.0 * case.half_width
            contact.mu = case.friction
            contact.weight_forces = contact.weight_moments = gains.force_weight
            contact.weight_tangentials = 0.0
            contacts[side] = contact
        com = solver.add_com_task(ticks.com[k])
        com.configure("com", "soft", gains.com_weight)
        com.kp = gains.com_kp
        torso = solver.add_orientation_task(TORSO, ticks.torso[k])
        torso.configure("torso", "soft", gains.torso_weight)
        torso.kp = gains.torso_kp
        posture = solver.add_joints_task()
        posture.set_joints(dict(zip(case.joints, map(float, ticks.posture), strict=True)))
        posture.configure("posture", "soft", gains.posture_weight)
        posture.kp = gains.posture_kp
        swing = None
        if stance in (LEFT, RIGHT):
            free = SOLES["right" if stance == LEFT else "left"]
            frame = solver.add_frame_task(free, ticks.swing[k])
            frame.configure("swing", "soft", gains.swing_weight, gains.swing_weight)
            swing = (frame.position(), frame.orientation())
            for part in swing:
                part.kp = gains.swing_kp
        return solver, com, torso, swing, contacts

    def tick(self, k: int) -> np.ndarray:
        """See `Adapter`."""
        solver, com, torso, swing, _ = self._per_tick[k]
        robot = self._robot
        state = robot.state
        state.q = self._q[k]
        state.qd = self._v[k]
        robot.update_kinematics()
        com.target_world = self._com[k]
        com.dtarget_world = self._dcom[k]
        com.ddtarget_world = self._ddcom[k]
        torso.R_world_frame = self._torso[k]
        torso.omega_world = self._omega[k]
        if swing is not None:
            position, orientation = swing
            T, v, a = self._swing[k], self._dswing[k], self._ddswing[k]
            position.target_world = T[:3, 3]
            position.dtarget_world = v[:3]
            position.ddtarget_world = a[:3]
            orientation.R_world_frame = T[:3, :3]
            orientation.omega_world = v[3:]
            orientation.domega_world = a[3:]
        self._result = result = solver.solve(False)
        self._last = k
        return result.tau

    def outcome(self) -> Outcome:
        """See `Adapter`."""
        contacts = self._per_tick[self._last][-1]
        result = self._result
        if not result.success:
            na = len(self._joints)
            nothing = np.full(6 + na, np.nan)
            return Outcome(False, nothing[6:], nothing, np.full((2, 6), np.nan))
        wrenches = np.zeros((2, 6))
        for index, side in enumerate(("left", "right")):
            if side in contacts:
                wrenches[index] = contacts[side].wrench.ravel()
        return Outcome(True, result.tau.ravel()[6:], result.qdd.ravel(), wrenches)
