"""Records the QPs of the controller of a robot that sways on its soles."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

import wbc
from wbc.command import Status
from wbc.qp import Problem

DT = 0.002


@dataclass(frozen=True)
class Motion:
    """A sway of the centre of mass and the torso.

    Attributes:
        amplitude: of the centre of mass, m: forward, left, up.
        frequency: Hz.
        yaw: amplitude of the torso's turning, rad.
        torque: factor on the torque limits.
        friction: coefficient of the contacts.
    """

    amplitude: tuple[float, float, float]
    frequency: float
    yaw: float
    torque: float = 1.0
    friction: float = 0.7


def controller(
    robot: wbc.Robot, motion: Motion, posture: np.ndarray, formulation: wbc.Formulation | None
) -> wbc.WholeBodyController:
    """A controller that sways; the centre of mass first, the torso second."""
    limits = (
        wbc.TorqueLimit(robot, scale=motion.torque),
        wbc.JointPositionLimit(robot),
        wbc.JointVelocityLimit(robot),
    )
    options = {} if formulation is None else {"formulation": formulation}
    made = wbc.WholeBodyController(robot, DT, limits=limits, **options)
    made.add(wbc.ComTask(weight=1000.0, kp=100.0))
    made.add(wbc.OrientationTask(robot.torso, weight=20.0))
    made.add(wbc.AngularMomentumTask(weight=0.01))
    made.add(wbc.PostureTask(robot, posture, weight=0.3))
    soles = [wbc.SurfaceContact.from_sole(sole, friction=motion.friction) for sole in robot.soles]
    made.set_contacts(soles)
    return made


def record(
    robot: wbc.Robot, motion: Motion, ticks: int, formulations: Sequence[wbc.Formulation]
) -> dict[wbc.Formulation, list[Problem]]:
    """The QPs of a sway, the controller's own accelerations integrated.

    Raises:
        SystemExit: a tick has no solution.
    """
    q = robot.q_nominal.copy()
    middle = 0.5 * (robot.q_min + robot.q_max)
    room = np.maximum(0.5 * (robot.q_max - robot.q_min) - 0.1, 0.0)
    q[7:] = np.clip(q[7:], middle - room, middle + room)  # no joint starts at a position limit
    state = wbc.State(q, np.zeros(robot.nv))
    kin = wbc.Kinematics(robot, state)
    start, upright = kin.p_com.copy(), kin.frame(robot.torso).rotation.copy()
    moving = controller(robot, motion, q[7:].copy(), None)
    watched = {f: controller(robot, motion, q[7:].copy(), f) for f in formulations}
    w = 2.0 * np.pi * motion.frequency
    shift = np.array([0.0, 0.5 * np.pi, 0.25 * np.pi])
    problems: dict[wbc.Formulation, list[Problem]] = {f: [] for f in formulations}
    rest = round(1.0 / motion.frequency / DT)  # the motion grows for one period
    every = max(1, rest // ticks)  # the recorded ticks cover a period
    for tick in range(2 * rest):
        size = min(tick / rest, 1.0)
        phase = w * DT * tick
        for control in (moving, *watched.values()):
            com, torso = control.tasks[:2]
            amplitude = size * np.array(motion.amplitude)
            com.target = start - (0.0, 0.0, amplitude[2]) + amplitude * np.sin(phase + shift)
            com.velocity = amplitude * w * np.cos(phase + shift)
            com.acceleration = -amplitude * w * w * np.sin(phase + shift)
            angle = motion.yaw * size * np.sin(phase)
            torso.target = pin.exp3(np.array([0.0, 0.0, angle])) @ upright
            torso.velocity = np.array([0.0, 0.0, motion.yaw * size * w * np.cos(phase)])
        command = moving.step(state)
        if command.status is not Status.OK:
            raise SystemExit(f"tick {tick} of the recording: {command.explanation}")
        if tick >= rest and (tick - rest) % every == 0 and len(problems[formulations[0]]) < ticks:
            for formulation, control in watched.items():
                control.step(state)
                problems[formulation].append(copy.deepcopy(control.problem))
        v = state.v + DT * command.acceleration
        state = wbc.State(pin.integrate(robot.model, state.q, DT * v), v)
    return problems
