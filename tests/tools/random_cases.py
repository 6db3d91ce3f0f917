"""Random controllers and the sequences of ticks that they solve."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import pinocchio as pin
from coretools import random_state, robot
from unreduced_qp import ControllerSetup

import wbc
from wbc.contacts import Contact
from wbc.limits import AccelerationBound, Limit, LimitRows

sys.path.append(str(Path(__file__).parents[2] / "benchmarks"))
from shared import synthetic

NAMED = ("talos", "g1", "simple_humanoid")
SYNTHETIC = ((16, 1), (20, 2), (24, 3), (28, 4), (33, 5), (40, 6))  # joints, seed
ROBOTS = (*NAMED, *NAMED, *SYNTHETIC)  # half of the cases on robots that exist
SOLES = ("both", "left", "right", "none")
CONTACTS = (
    *SOLES,
    *("both, second soft", "both soft", "points", "one point", "sole and hand"),
    *("soles and soft hand", "four surfaces", "the same sole twice", "both soles twice"),
)


@dataclass(frozen=True)
class Case:
    """One random controller and the number of its ticks.

    Attributes:
        kind: one of KINDS.
        robot: a name, or joints and seed of a synthetic humanoid.
        seed: of everything else.
        ticks: length of the sequence.
    """

    kind: str
    robot: str | tuple[int, int]
    seed: int
    ticks: int


KINDS = {
    "any contacts": 1,
    "limits active": 1,
    "exact tasks": 1,
    "degenerate": 1,
    "extreme weights": 1,
    "infeasible": 1,
    "smooth sequence": 12,
    "switching contacts": 12,
    "unloading a foot": 12,
    "own limits and contacts": 4,
}  # and ticks of each


def cases(count: int, seed: int = 0, kinds: Sequence[str] = tuple(KINDS)) -> Iterator[Case]:
    """Yield cases of `count` ticks in all, or a few more, evenly over the kinds."""
    rng = np.random.default_rng(seed)
    made = dict.fromkeys(kinds, 0)
    while sum(made.values()) < count:
        kind = min(made, key=lambda k: made[k])
        made[kind] += KINDS[kind]
        name = ROBOTS[rng.integers(len(ROBOTS))]
        yield Case(kind, name, int(rng.integers(2**31)), KINDS[kind])


@lru_cache
def robot_of(case: Case) -> wbc.Robot:
    """Return the robot of a case. The result is cached."""
    return _synthetic(case.robot) if isinstance(case.robot, tuple) else robot(case.robot)


@lru_cache
def _synthetic(which: tuple[int, int]) -> wbc.Robot:
    return synthetic.load(*which)


class PrescribedAcceleration(AccelerationBound):
    """Prescribes the accelerations of some joints: lower and upper bounds coincide."""

    name = "prescribed acceleration"

    def __init__(self, robot: wbc.Robot, joints: np.ndarray, value: float) -> None:
        self.low = np.full(robot.na, -100.0)
        self.high = np.full(robot.na, 100.0)
        self.low[joints] = self.high[joints] = value

    def bounds(self, kin: wbc.Kinematics) -> tuple[np.ndarray, np.ndarray]:
        return self.low, self.high


class VerticalForce(Limit):
    """Limits the vertical contact force to a share of the robot's weight."""

    def __init__(self, robot: wbc.Robot, share: float) -> None:
        super().__init__("vertical force", 1, unit="N")
        self.maximum = share * robot.weight

    def write(self, kin: wbc.Kinematics, rows: LimitRows) -> None:
        for contact, F in rows.forces.items():
            F[0, :3] = kin.frame(contact.frame).rotation[2]
        rows.upper[0] = self.maximum


class HandHeight(Limit):
    """A control barrier that keeps the hands above a height; it is inactive for higher hands."""

    def __init__(self, robot: wbc.Robot, height: float) -> None:
        super().__init__("hand height", 2, unit="m/s²", labels=("left", "right"))
        self.height = height
        self.frames = hands(robot)

    def write(self, kin: wbc.Kinematics, rows: LimitRows) -> None:
        for k, frame in enumerate(self.frames):
            hand = kin.motion(frame)
            distance = hand.position[2] - self.height
            if distance < 0.3:
                rows.A[k] = hand.jacobian[2]
                rows.lower[k] = -hand.bias[2] - 20.0 * hand.velocity[2] - 100.0 * distance


class SixteenSidedSole(wbc.SurfaceContact):
    """A sole with a finer friction cone: more rows than any of the library's contacts has."""

    def make_cone(self, mu: float) -> np.ndarray:
        angles = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
        sides = np.zeros((16, 6))
        sides[:, 0], sides[:, 1], sides[:, 2] = np.cos(angles), np.sin(angles), -1.2 * mu
        return np.vstack((super().make_cone(mu), sides))

    @property
    def cone_labels(self) -> tuple[str, ...]:
        return (*super().cone_labels, *(f"friction side {k}" for k in range(16)))


class CaseRunner:
    """Sets up the controller of a case and changes state, contacts and weights from tick to tick.

    Every instance of one case draws the same numbers, so that a controller and the reference
    can each have their own tasks.
    """

    def __init__(self, case: Case) -> None:
        self.case = case
        self.robot = robot_of(case)
        self.rng = np.random.default_rng(case.seed)
        self.chosen = self._choose_contacts()
        self.state = self._first_state()
        bounds, torque = self._limits()
        self.setup = ControllerSetup(
            self.robot, self._tasks(), self.kept[self.chosen], bounds, torque
        )
        if case.kind == "own limits and contacts":
            self.setup.limits = self._own_limits()
            self.setup.contacts = [
                SixteenSidedSole(s.name, s.half_length, s.half_width, friction=0.5)
                for s in self.robot.soles[: self.rng.integers(1, 3)]
            ] + self.setup.contacts[2:]
        for thing in (
            *self.setup.tasks,
            *self.setup.contacts,
            *(c for some in self.kept.values() for c in some),
        ):
            thing.bind(self.robot)

    def controller(
        self, solver: str | None = None, formulation: wbc.Formulation | None = None
    ) -> wbc.WholeBodyController:
        """Return a controller of this setup; None takes the default solver or formulation."""
        setup = self.setup
        torque = [] if setup.torque_limit is None else [setup.torque_limit]
        options = {"solver": solver, "formulation": formulation}
        options = {name: value for name, value in options.items() if value is not None}
        limits = [*torque, *setup.bounds, *setup.limits]
        made = wbc.WholeBodyController(self.robot, limits=limits, **options)
        for task in setup.tasks:
            made.add(task)
        made.set_contacts(setup.contacts)
        return made

    def advance(self, tick: int) -> None:
        """Go on to a tick: change the state and whatever else the kind of case changes."""
        if tick == 0:
            return
        rng, kind = self.rng, self.case.kind
        v = self.state.v + 0.05 * rng.standard_normal(self.robot.nv)
        self.state = wbc.State(pin.integrate(self.robot.model, self.state.q, 0.002 * v), v)
        for task in self.setup.tasks:
            if hasattr(task, "acceleration"):
                task.acceleration = task.acceleration + 0.1 * rng.standard_normal(task.size)
        if kind == "switching contacts" and rng.random() < 0.4:
            self.setup.contacts = self.kept[SOLES[rng.integers(len(SOLES))]]
            if rng.random() < 0.3:  # an unrelated state
                self.state = random_state(self.robot, int(rng.integers(2**31)), spread=0.05)
        elif kind == "smooth sequence" and rng.random() < 0.2:
            task = self.setup.tasks[rng.integers(len(self.setup.tasks))]
            task.weight = task.weight * 10.0 ** rng.uniform(-1.0, 1.0)
        elif kind == "unloading a foot":
            share = max(0.0, 1.0 - tick / 8)
            foot = self.setup.contacts[-1]
            foot.min_force = 0.0
            foot.max_force = share * self.robot.weight

    def _choose_contacts(self) -> str:
        kind, rng = self.case.kind, self.rng
        made = {name: contact_set(self.robot, name, rng) for name in CONTACTS}
        self.kept = made
        if kind in ("switching contacts", "smooth sequence"):
            return SOLES[rng.integers(len(SOLES))]
        if kind == "unloading a foot":
            return ("both", "both, second soft")[rng.integers(2)]
        if kind == "degenerate":
            name = CONTACTS[-3:][rng.integers(3)]
            foot = made[name][0]
            foot.max_force = foot.min_force = (0.0, 0.3 * self.robot.weight)[rng.integers(2)]
            if rng.random() < 0.5:
                foot.max_force, foot.min_force = np.inf, 0.0
            return name
        return CONTACTS[rng.integers(len(CONTACTS))]

    def _first_state(self) -> wbc.State:
        rng = self.rng
        level = 10.0 ** rng.uniform(-2.0, -0.5)
        speed = 10.0 ** rng.uniform(-2.0, 0.3)
        if self.case.ticks > 1:
            level, speed = 0.02, 0.1
        seed = int(rng.integers(2**31))
        return random_state(self.robot, seed, spread=level, speed=speed, tilt=level)

    def _limits(self) -> tuple[list[AccelerationBound], wbc.TorqueLimit | None]:
        bot, rng = self.robot, self.rng
        position, velocity = wbc.JointPositionLimit(bot), wbc.JointVelocityLimit(bot)
        if self.case.kind == "limits active":
            scale = 10.0 ** rng.uniform(-0.8, -0.1)
            slow = wbc.JointVelocityLimit(bot, rng.uniform(0.3, 3.0))
            hard = wbc.JointAccelerationLimit(bot, rng.uniform(20.0, 60.0))
            return [position, slow, hard], wbc.TorqueLimit(bot, scale=scale)
        if self.case.kind == "degenerate" and rng.random() < 0.5:
            some = rng.choice(bot.na, 3, replace=False)
            return [PrescribedAcceleration(bot, some, rng.uniform(-0.5, 0.5))], wbc.TorqueLimit(bot)
        if rng.random() < 0.1:
            return [], None
        return [position, velocity], wbc.TorqueLimit(bot)

    def _own_limits(self) -> list[Limit]:
        bot, rng = self.robot, self.rng
        height = wbc.Kinematics(bot, self.state).frame(hands(bot)[0]).translation[2]
        force = VerticalForce(bot, rng.uniform(0.5, 1.1))
        return [force, HandHeight(bot, height + rng.uniform(-0.3, 0.02))][rng.integers(2) :]

    def _tasks(self) -> list[wbc.Task]:
        bot, rng, kind = self.robot, self.rng, self.case.kind
        decades = (-5.0, 5.0) if kind == "extreme weights" else (-1.0, 3.5)

        def weight(size: int) -> np.ndarray:
            w = 10.0 ** (rng.uniform(*decades) + rng.uniform(-0.5, 0.5, size))
            w[rng.random(size) < 0.1] = 0.0
            return w

        links = [f.name for f in bot.model.frames if f.type == pin.FrameType.BODY]
        tasks: list[wbc.Task] = []
        if rng.random() < 0.9:
            tasks.append(wbc.ComTask(weight=weight(3), kp=rng.uniform(5.0, 100.0)))
        if rng.random() < 0.7:
            tasks.append(wbc.OrientationTask(bot.torso, weight=weight(3)))
        if rng.random() < 0.5:
            tasks.append(wbc.AngularMomentumTask(weight=1e-3 * weight(3)))
        if rng.random() < 0.9 or not tasks:
            joints = list(bot.joint_names)
            if rng.random() < 0.3:
                joints = [str(j) for j in rng.permutation(joints)[: bot.na // 2]]
            tasks.append(wbc.PostureTask(bot, joints=joints, weight=1e-2 * weight(len(joints))))
        for k in range(rng.integers(4)):
            made = (wbc.FrameTask, wbc.PositionTask, wbc.OrientationTask)[rng.integers(3)]
            size = 6 if made is wbc.FrameTask else 3
            link = links[rng.integers(len(links))]
            tasks.append(made(link, weight=weight(size), name=f"{link} {k}"))
        for task in tasks:
            if hasattr(task, "acceleration"):
                task.acceleration = 0.5 * rng.standard_normal(task.size)
        return tasks + self._exact_tasks()

    def _exact_tasks(self) -> list[wbc.Task]:
        bot, rng, kind = self.robot, self.rng, self.case.kind
        if kind == "exact tasks":
            hand = hands(bot)[rng.integers(2)]
            two = [str(j) for j in rng.permutation(bot.joint_names)[:2]]
            choices: list[list[wbc.Task]] = [
                [wbc.PositionTask(hand, priority=0, name="exact hand")],
                [
                    wbc.PostureTask(
                        bot, joints=two, target=np.zeros(2), kp=1.0, priority=0, name="exact joints"
                    )
                ],
                [wbc.OrientationTask(bot.torso, priority=0, name="exact torso")],
                [wbc.ComTask(priority=0, name="exact com")],
            ]
            return choices[rng.integers(len(choices))]
        if kind == "infeasible":
            up = wbc.ComTask(priority=0, name="jump")
            up.acceleration = np.array([0.0, 0.0, 10.0 ** rng.uniform(0.5, 2.5)])
            if rng.random() < 0.5:
                return [up]
            again = wbc.PositionTask(bot.torso, priority=0, name="here")
            there = wbc.PositionTask(bot.torso, priority=0, name="there")
            there.acceleration = 10.0 ** rng.uniform(-4.0, 1.0) * rng.standard_normal(3)
            return [again, there]
        return []


@lru_cache
def hands(robot: wbc.Robot) -> tuple[str, str]:
    """Return the links at the ends of the longest chains left and right that are no legs."""
    model, kin = robot.model, wbc.Kinematics(robot, robot.standing())
    legs = {j for leg in robot.legs for j in leg}
    free = [j for j in range(2, model.njoints) if model.joints[j].idx_v not in legs]
    names = []
    for side in (1.0, -1.0):
        end = max(
            free,
            key=lambda j: (side * kin.data.oMi[j].translation[1] > 0.1, len(model.supports[j])),
        )
        names.append(
            next(
                f.name
                for f in model.frames
                if f.parentJoint == end and f.type == pin.FrameType.BODY
            )
        )
    return names[0], names[1]


def contact_set(robot: wbc.Robot, name: str, rng: np.random.Generator) -> list[Contact]:
    """Return the contacts of a named set, with random friction."""
    mu = rng.uniform(0.2, 1.0)

    def sole(side: str, **options: object) -> Contact:
        s = robot.sole(side)
        return wbc.SurfaceContact(s.name, s.half_length, s.half_width, friction=mu, **options)

    def palm(k: int) -> Contact:
        return wbc.SurfaceContact(hands(robot)[k], 0.05, 0.03, friction=mu, motion_weight=1000.0)

    def point(frame: str, **options: object) -> Contact:
        return wbc.PointContact(frame, friction=mu, **options)

    sets: dict[str, Sequence[Contact]] = {
        "both": (sole("left"), sole("right")),
        "left": (sole("left"),),
        "right": (sole("right"),),
        "none": (),
        "both, second soft": (sole("left"), sole("right", motion_weight=3000.0)),
        "both soft": (sole("left", motion_weight=3000.0), sole("right", motion_weight=1000.0)),
        "points": (point("left_sole"), point("right_sole")),
        "one point": (point("right_sole"),),
        "sole and hand": (sole("left"), point(hands(robot)[1])),
        "soles and soft hand": (
            sole("left"),
            sole("right"),
            point(hands(robot)[0], motion_weight=1000.0),
        ),
        "four surfaces": (sole("left"), sole("right"), palm(0), palm(1)),
        "the same sole twice": (sole("left"), point("left_sole", name="again")),
        "both soles twice": (
            *(sole("left"), sole("right")),
            *(sole("left", name="left again"), sole("right", name="right again")),
        ),
    }
    return list(sets[name])
