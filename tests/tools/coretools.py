"""Helpers for the tests of kinematics, tasks, contacts, limits and QP."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import TypeVar

import numpy as np
import pinocchio as pin
from hypothesis import settings
from hypothesis import strategies as st

import wbc
from wbc.contacts import Contact
from wbc.limits import AccelerationBound

ROBOTS = ("talos", "g1", "romeo", "simple_humanoid")

few = settings(max_examples=8)
some = settings(max_examples=20)
many = settings(max_examples=60)

robots = st.sampled_from(ROBOTS)
seeds = st.integers(0, 2**31)


@lru_cache
def robot(name: str) -> wbc.Robot:
    return wbc.load(name)


def random_state(
    robot: wbc.Robot,
    seed: int,
    *,
    spread: float = 0.3,
    speed: float = 0.5,
    place: float = 2.0,
    tilt: float = 1.0,
) -> wbc.State:
    """Nominal posture, joints off by `spread` rad, anywhere within `place` m, any yaw."""
    rng = np.random.default_rng(seed)
    model = robot.model
    step = spread * rng.standard_normal(robot.nv)
    step[:6] = 0.0
    q = pin.integrate(model, robot.q_nominal, step)
    low, high = robot.q_min + 0.05, robot.q_max - 0.05
    q[7:] = np.clip(q[7:], np.minimum(low, high), np.maximum(low, high))
    lean = pin.exp3(tilt * 0.3 * rng.standard_normal(3))
    turn = pin.rpy.rpyToMatrix(0.0, 0.0, rng.uniform(-3.0, 3.0))
    q[3:7] = pin.Quaternion(turn @ lean).normalized().coeffs()
    q[:3] += place * rng.uniform(-1.0, 1.0, 3)
    return wbc.State(q, speed * rng.standard_normal(robot.nv))


def standing_state(robot: wbc.Robot, seed: int, *, speed: float = 0.1) -> wbc.State:
    """Return a state close to standing, in which the tasks are feasible."""
    return random_state(robot, seed, spread=0.02, speed=speed, place=0.1, tilt=0.02)


def hand(robot: wbc.Robot) -> str:
    """Link at the end of the longest chain that is no leg."""
    model = robot.model
    legs = {j for leg in robot.legs for j in leg}
    free = [j for j in range(2, model.njoints) if model.joints[j].idx_v not in legs]
    last = max(free, key=lambda j: len(model.supports[j]))
    return next(
        f.name for f in model.frames if f.parentJoint == last and f.type == pin.FrameType.BODY
    )


T = TypeVar("T")


def along_velocity(
    robot: wbc.Robot, state: wbc.State, h: float, evaluate: Callable[[wbc.State], T]
) -> tuple[T, T, T]:
    """What `evaluate` gives h s before, in, and h s after a state, at constant velocity."""
    q = [pin.integrate(robot.model, state.q, t * state.v) for t in (-h, 0.0, h)]
    before, now, after = (evaluate(wbc.State(at, state.v)) for at in q)
    return before, now, after


def sole_contact(
    robot: wbc.Robot, side: str, motion_weight: float | None = None
) -> wbc.SurfaceContact:
    sole = robot.sole(side)
    return wbc.SurfaceContact(
        sole.name, sole.half_length, sole.half_width, motion_weight=motion_weight
    )


def contact_set(robot: wbc.Robot, name: str) -> list[Contact]:
    """Return the contacts of a named set; the frame names differ between robots."""
    left, right = "left_sole", "right_sole"
    sets: dict[str, list[Contact]] = {
        "none": [],
        "left": [sole_contact(robot, "left")],
        "right": [sole_contact(robot, "right")],
        "both": [sole_contact(robot, "left"), sole_contact(robot, "right")],
        "left exact, right soft": [
            sole_contact(robot, "left"),
            sole_contact(robot, "right", 3000.0),
        ],
        "both soft": [
            sole_contact(robot, "left", 3000.0),
            sole_contact(robot, "right", 3000.0),
        ],
        "points": [wbc.PointContact(left), wbc.PointContact(right)],
        "sole and hand": [sole_contact(robot, "left"), wbc.PointContact(hand(robot))],
        "soles and hand": [
            sole_contact(robot, "left"),
            sole_contact(robot, "right", 3000.0),
            wbc.PointContact(hand(robot), motion_weight=1000.0),
        ],
    }
    return sets[name]


CONTACT_SETS = (
    *("none", "left", "right", "both", "left exact, right soft", "both soft"),
    *("points", "sole and hand", "soles and hand"),
)
SOLE_SETS = ("left", "right", "both", "left exact, right soft")


def controller(
    robot: wbc.Robot,
    contacts: str | Sequence[Contact] = "both",
    *,
    solver: str = "daqp",
    formulation: wbc.Formulation = wbc.Formulation.REDUCED,
    limits: Sequence[wbc.TorqueLimit | AccelerationBound] | None = None,
) -> wbc.WholeBodyController:
    """A controller that stands: CoM, trunk, posture and momentum tasks."""
    made = wbc.WholeBodyController(robot, solver=solver, formulation=formulation, limits=limits)
    made.add(wbc.ComTask(weight=1000.0))
    made.add(wbc.OrientationTask(robot.torso, weight=20.0))
    made.add(wbc.AngularMomentumTask(weight=0.01))
    made.add(wbc.PostureTask(robot, weight=0.3))
    made.set_contacts(contact_set(robot, contacts) if isinstance(contacts, str) else contacts)
    return made


def force_of(contact: Contact, command: wbc.Command) -> np.ndarray:
    """The contact's force unknowns, contact axes."""
    return command.wrenches[contact.name][: contact.motion_size]


def contact_jacobian(robot: wbc.Robot, state: wbc.State, contact: Contact) -> np.ndarray:
    """(motion_size, nv) by Pinocchio's own call, contact axes."""
    data = robot.model.createData()
    pin.computeJointJacobians(robot.model, data, state.q)
    frame = robot.frame_id(contact.frame)
    J = pin.getFrameJacobian(robot.model, data, frame, pin.ReferenceFrame.LOCAL)
    return J[: contact.motion_size]


def residual(robot: wbc.Robot, state: wbc.State, contacts: Sequence[Contact], command: wbc.Command):
    """(nv,) `M v̇ + h − Sᵀ τ − Jᵀ f`, everything but the command from fresh Pinocchio calls."""
    model, data = robot.model, robot.model.createData()
    pin.computeAllTerms(model, data, state.q, state.v)
    gap = data.M @ command.acceleration + data.nle
    gap[6:] -= command.tau
    for contact in contacts:
        gap -= contact_jacobian(robot, state, contact).T @ force_of(contact, command)
    return gap


def contact_acceleration(
    robot: wbc.Robot, state: wbc.State, contact: Contact, command: wbc.Command
) -> tuple[np.ndarray, np.ndarray]:
    """Velocity and classical acceleration of the contact's frame, contact axes."""
    model, data = robot.model, robot.model.createData()
    pin.forwardKinematics(model, data, state.q, state.v, command.acceleration)
    frame = robot.frame_id(contact.frame)
    local = pin.ReferenceFrame.LOCAL
    n = contact.motion_size
    return (
        pin.getFrameVelocity(model, data, frame, local).vector[:n],
        pin.getFrameClassicalAcceleration(model, data, frame, local).vector[:n],
    )
