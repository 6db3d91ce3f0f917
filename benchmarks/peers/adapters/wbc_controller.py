"""Adapter of `wbc.WholeBodyController`."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

import numpy as np
import pinocchio as pin

import wbc
from peers.case import SOLES, Case
from peers.measuring import Outcome
from peers.problem import Problem

FLAT_ROWS = 8  # rows of friction and centre of pressure in the wrench cone, without the yaw moment


class Wbc:
    """Uses one controller for each set of standing feet."""

    momentum = True
    contact = wbc.SurfaceContact

    def __init__(self, case: Case) -> None:
        self.versions = {"wbc": wbc_version(), "pin": pin.__version__}
        robot = wbc.load(case.robot)
        ticks = case.ticks
        kin = wbc.Kinematics(robot, wbc.State(ticks.q[0], ticks.v[0]))
        case.check_model(kin.mass_matrix, kin.bias_forces, list(robot.joint_names))
        problem = Problem(
            robot,
            case.limits,
            case.gains,
            case.half_length,
            case.half_width,
            case.friction,
            ticks.posture,
            self.momentum,
            self.contact,
        )
        self._stances = {s: problem.controller(s) for s in np.unique(ticks.stance)}
        self._per_tick = [self._stances[s] for s in ticks.stance]
        self._q, self._v = list(ticks.q), list(ticks.v)
        # References in the types that the tasks take.
        self._com, self._dcom = list(ticks.com), list(ticks.com_velocity)
        self._ddcom = list(ticks.com_acceleration)
        self._torso, self._omega = list(ticks.torso), list(ticks.torso_velocity)
        self._swing = [pin.SE3(T[:3, :3], T[:3, 3]) for T in ticks.swing]
        self._dswing, self._ddswing = list(ticks.swing_velocity), list(ticks.swing_acceleration)

    def tick(self, k: int) -> np.ndarray:
        """See `Adapter`."""
        tasks = self._per_tick[k]
        com, torso, swing = tasks.com, tasks.torso, tasks.swing
        com.target = self._com[k]
        com.velocity = self._dcom[k]
        com.acceleration = self._ddcom[k]
        torso.target = self._torso[k]
        torso.velocity = self._omega[k]
        if swing is not None:
            swing.target = self._swing[k]
            swing.velocity = self._dswing[k]
            swing.acceleration = self._ddswing[k]
        self._command = command = tasks.controller.step(wbc.State(self._q[k], self._v[k]))
        return command.tau

    def outcome(self) -> Outcome:
        """See `Adapter`."""
        command = self._command
        zero = np.zeros(6)
        wrenches = [command.wrenches.get(SOLES[side], zero) for side in ("left", "right")]
        ok = command.status is wbc.Status.OK
        return Outcome(ok, command.tau, command.acceleration, np.array(wrenches))


class FlatContact(wbc.SurfaceContact):
    """A sole without a limit of the yaw moment, as in placo."""

    def make_cone(self, mu: float) -> np.ndarray:
        return super().make_cone(mu)[:FLAT_ROWS]

    @property
    def cone_labels(self) -> tuple[str, ...]:
        """See `wbc.Contact`."""
        return super().cone_labels[:FLAT_ROWS]


class WbcLikePlaco(Wbc):
    """Solves placo's problem: without angular momentum and without a limit of the yaw moment."""

    momentum = False
    contact = FlatContact


def wbc_version() -> str:
    """Return the installed version, or that it is a source checkout."""
    try:
        return version("wbc")
    except PackageNotFoundError:
        return "checkout"
