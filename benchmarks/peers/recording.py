"""Records the ticks of the cases: a simulated walk, and a fast motion at the limits."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

import wbc
from peers.case import BOTH, LEFT, RIGHT, SOLES, TORSO, Case, Gains, Limits, Ticks
from peers.problem import Problem
from peers.robot_file import urdf_text
from wbc.limits import JointPositionLimit, JointVelocityLimit, TorqueLimit

DT = 0.002
MARGIN = 0.005  # of the soles, m
FRICTION = 0.6  # Coulomb coefficient; the pyramid's is this over √2
HARD_FRICTION, HARD_TORQUE = 0.2, 0.3
SPEED, DURATION = 0.3, 4.0  # of the recorded walks, m/s and s
SINGLE = -1
CASES = {  # name: (title, robot, stance; None for the sway)
    "talos-double": ("Talos, two feet", "talos", BOTH),
    "talos-single": ("Talos, one foot", "talos", SINGLE),
    "g1-double": ("G1, two feet", "g1", BOTH),
    "g1-single": ("G1, one foot", "g1", SINGLE),
    "talos-hard": ("Talos, at its limits", "talos", None),
}
_CODES = {("left_sole",): LEFT, ("right_sole",): RIGHT}
_STILL = np.eye(4)


class Recorder:
    """A walker that records its states and references."""

    def __init__(self, walker: wbc.Walker) -> None:
        self.walker = walker
        self.rows: list[dict[str, object]] = []
        self._kin = wbc.Kinematics(walker.robot, walker.robot.standing())

    def reset(self, state: wbc.State) -> None:
        """See `wbc.Walker.reset`."""
        self.walker.reset(state)

    def step(self, estimate: wbc.Estimate) -> wbc.Command:
        """See `wbc.Walker.step`."""
        command = self.walker.step(estimate)
        if self.walker.steps >= 1:
            self.rows.append(self.row(estimate.state))
        return command

    def row(self, state: wbc.State) -> dict[str, object]:
        """Return the walker's references of its last tick.

        Its CoM task has no stiffness in x and y; the reference there is the measured CoM.
        """
        kin, tasks = self._kin, self.walker.controller.tasks
        kin.update(state)
        com = next(t for t in tasks if isinstance(t, wbc.ComTask))
        torso_name = self.walker.robot.torso
        torso = next(
            t for t in tasks if isinstance(t, wbc.OrientationTask) and t.frame == torso_name
        )
        foot = self.walker.gait_state.swing
        names = tuple(c.name for c in self.walker.controller.contacts)
        return {
            "q": state.q.copy(),
            "v": state.v.copy(),
            "stance": _CODES.get(names, BOTH),
            "com": np.array([*kin.p_com[:2], com.target[2]]),
            "com_velocity": np.array([*kin.v_com[:2], 0.0]),
            "com_acceleration": com.acceleration.copy(),
            "torso": torso.target.copy(),
            "torso_velocity": torso.velocity.copy(),
            "swing": foot.motion.pose.copy() if foot else _STILL,
            "swing_velocity": foot.motion.velocity.copy() if foot else np.zeros(6),
            "swing_acceleration": foot.motion.acceleration.copy() if foot else np.zeros(6),
        }


def record_walk(robot: wbc.Robot, speed: float, duration: float) -> Ticks:
    """Return the ticks of a walk in MuJoCo from the first touchdown on.

    Raises:
        RuntimeError: the robot fell.
    """
    from wbc.sim import Mujoco

    recorder = Recorder(wbc.Walker(robot, DT))
    recorder.walker.velocity = (speed, 0.0, 0.0)
    with Mujoco(robot, ground_truth=True) as plant:
        report = wbc.run(recorder, plant, duration, estimator=wbc.GroundTruthEstimator(robot))
    if not report.survived:
        raise RuntimeError(f"{robot.name} fell at {report.fell_at_s:.2f} s: {report.fell_why}")
    return stack(recorder.rows, recorder.walker.posture.target.copy())


def stack(rows: Iterable[Mapping[str, object]], posture: np.ndarray) -> Ticks:
    """Return the ticks of recorded rows."""
    rows = list(rows)
    return Ticks(**{k: np.array([row[k] for row in rows]) for k in rows[0]}, posture=posture)


@dataclass(frozen=True)
class Sway:
    """A fast motion in double support: sine waves of the CoM and of the torso's heading.

    Attributes:
        amplitude: of the CoM, m: forward, left, up.
        frequency: of the same, Hz; the torso turns at the second one.
        yaw: amplitude of the torso's turning, rad.
        rest: time in which the motion grows to full size, s; not recorded.
    """

    amplitude: tuple[float, float, float] = (0.01, 0.02, 0.01)
    frequency: tuple[float, float, float] = (1.0, 1.0, 2.0)
    yaw: float = 0.2
    rest: float = 0.5


def record_sway(robot: wbc.Robot, problem: Problem, sway: Sway, count: int) -> Ticks:
    """Return the ticks of a motion at the limits.

    The accelerations that the controller finds are integrated: what it could not do within
    the limits, the robot does not do, so that every state is one from which the limits can be
    kept, and the references run ahead of it.

    Raises:
        RuntimeError: some tick had no solution.
    """
    state = away_from_stops(robot)
    kin = wbc.Kinematics(robot, state)
    start, upright = kin.p_com.copy(), kin.frame(robot.torso).rotation.copy()
    A, w = np.array(sway.amplitude), 2.0 * np.pi * np.array(sway.frequency)
    phase = np.array([0.0, 0.5, 0.25]) * np.pi
    lowered = np.array([0.0, 0.0, sway.amplitude[2]])  # the legs do not stretch
    rest = round(sway.rest / DT)
    rows = []
    posture = state.q[7:].copy()
    tasks = replace(problem, posture=posture).controller(BOTH, DT)
    q, v = state.q.copy(), state.v.copy()
    for k in range(rest + count):
        t, size = k * DT, min(k / rest, 1.0)
        angle = sway.yaw * size * math.sin(w[1] * t)
        row = {
            "q": q,
            "v": v,
            "stance": BOTH,
            "com": start - lowered + size * A * np.sin(w * t + phase),
            "com_velocity": size * A * w * np.cos(w * t + phase),
            "com_acceleration": -size * A * w * w * np.sin(w * t + phase),
            "torso": pin.exp3(np.array([0.0, 0.0, angle])) @ upright,
            "torso_velocity": np.array([0.0, 0.0, sway.yaw * size * w[1] * math.cos(w[1] * t)]),
            "swing": _STILL,
            "swing_velocity": np.zeros(6),
            "swing_acceleration": np.zeros(6),
        }
        rows.append(row)
        tasks.com.target, tasks.com.velocity = row["com"], row["com_velocity"]
        tasks.com.acceleration = row["com_acceleration"]
        tasks.torso.target, tasks.torso.velocity = row["torso"], row["torso_velocity"]
        command = tasks.controller.step(wbc.State(q, v))
        if command.status is not wbc.Status.OK:
            raise RuntimeError(f"tick {k} of the sway: {command.explanation}")
        a = command.acceleration
        q, v = pin.integrate(robot.model, q, DT * v + 0.5 * DT * DT * a), v + DT * a
    return stack(rows[rest:], posture)


def away_from_stops(robot: wbc.Robot, distance: float = 0.05) -> wbc.State:
    """Return the nominal posture with every joint at least `distance` (rad) from its limits.

    On a stop the libraries' position limits differ most, down to one that jumps there.
    """
    state = robot.standing()
    room = np.minimum(distance, 0.25 * (robot.q_max - robot.q_min))
    state.q[7:] = np.clip(state.q[7:], robot.q_min + room, robot.q_max - room)
    return state


def make_problem(
    robot: wbc.Robot, *, torque_scale: float = 1.0, friction: float = FRICTION
) -> Problem:
    """Return the problem of a robot with the default limits of `wbc`."""
    position, velocity = JointPositionLimit(robot, margin=0.0), JointVelocityLimit(robot)
    sole = robot.soles[0]
    return Problem(
        robot,
        Limits(
            torque=TorqueLimit(robot, scale=torque_scale).maximum,
            velocity=np.array(velocity.maximum),
            lower=np.array(position.lower),
            upper=np.array(position.upper),
            braking=np.array(position.braking),
            horizon=position.horizon,
        ),
        Gains(),
        half_length=sole.half_length - MARGIN,
        half_width=sole.half_width - MARGIN,
        friction=friction / math.sqrt(2.0),
        posture=robot.q_nominal[7:].copy(),
    )


def make_case(name: str, title: str, problem: Problem, ticks: Ticks) -> Case:
    """Return the case of a problem and its recorded ticks."""
    robot = problem.robot
    kin = wbc.Kinematics(robot, wbc.State(ticks.q[0], ticks.v[0]))
    frames = {SOLES[s.side]: s.frame_id for s in robot.soles}
    frames[TORSO] = robot.frame_id(robot.torso)
    return Case(
        name=name,
        title=title,
        robot=robot.name,
        urdf=urdf_text(robot.model, frames),
        joints=robot.joint_names,
        armature=np.array(robot.model.armature)[6:],
        half_length=problem.half_length,
        half_width=problem.half_width,
        friction=problem.friction,
        limits=problem.limits,
        ticks=ticks,
        mass_matrix=np.array(kin.mass_matrix),
        bias_forces=np.array(kin.bias_forces),
        gains=problem.gains,
    )


def record_cases(names: Sequence[str], count: int) -> list[Case]:
    """Return the named cases with at most `count` ticks each.

    Raises:
        KeyError: there is no case of that name.
        RuntimeError: the robot fell or had no solution while being recorded.
    """
    cases = []
    walks: dict[str, Ticks] = {}
    for name in names:
        title, robot_name, stance = CASES[name]
        robot = wbc.load(robot_name)
        if stance is None:
            problem = make_problem(robot, torque_scale=HARD_TORQUE, friction=HARD_FRICTION)
            ticks = record_sway(robot, problem, Sway(), count)
        else:
            problem = make_problem(robot)
            if robot_name not in walks:
                walks[robot_name] = record_walk(robot, SPEED, DURATION)
            walk = walks[robot_name]
            double = walk.stance == BOTH
            ticks = walk.part(np.flatnonzero(double if stance == BOTH else ~double)[:count])
        cases.append(make_case(name, title, problem, ticks))
    return cases
