"""Bodies of a robot are kept apart."""

from __future__ import annotations

import copy
import pickle

import coal
import numpy as np
import pinocchio as pin
import pytest
from coretools import random_state, robot, seeds
from hypothesis import given, settings

import wbc
from wbc.errors import LimitError
from wbc.limits import BarrierRows, ObstacleLimit, SelfCollisionLimit
from wbc.robot.self_collision import SelfCollision
from wbc.robot.upper_body import UpperBody


def barrier_of(limit: SelfCollisionLimit, one: wbc.Robot, state: wbc.State) -> BarrierRows:
    m = limit.size
    rows = BarrierRows(np.full(m, np.inf), np.zeros((m, one.nv)), np.zeros(m))
    limit.write_barrier(wbc.Kinematics(one, state), rows)
    return rows


@given(seed=seeds)
@settings(max_examples=4)
def test_rates_of_the_distances_equal_their_finite_differences(seed):
    one, limit = robot("g1"), SelfCollisionLimit(robot("g1"), margin=0.0, detection=0.2)
    state = random_state(one, seed)
    rows = barrier_of(limit, one, state)
    near = np.array([k for _, k, *_ in limit._near.update(wbc.Kinematics(one, state), 0.2)])
    near = near[np.argsort(SelfCollision.of(one).distances(state.q)[near])]
    step, pairs = 1e-6, SelfCollision.of(one)
    ahead, behind = (
        pairs.distances(pin.integrate(one.model, state.q, sign * step * state.v))[near]
        for sign in (1.0, -1.0)
    )
    near = near[: limit.size]
    error = np.abs(((ahead - behind) / (2.0 * step))[: near.size] - (rows.J @ state.v)[: near.size])
    # Nearest points jump from one edge to another where faces are parallel.
    assert np.median(error) < 1e-4
    assert np.quantile(error, 0.8) < 1e-3


def test_pairs_are_told_and_leave_out_what_always_touches():
    pairs = SelfCollision.of(robot("g1"))
    assert "pairs of bodies watched" in pairs.report()
    assert {pair.reason for pair in pairs.excluded} == {"adjacent", "joint range"}
    assert pairs.least_distance(robot("g1").q_nominal)[0] > 0.0
    assert copy.deepcopy(pairs) is pairs
    assert {pair.reason for pair in SelfCollision.of(robot("talos")).excluded} >= {"SRDF"}


@given(seed=seeds)
@settings(max_examples=4)
def test_hands_told_to_go_through_the_body_do_not_penetrate_it(seed):
    one, random = robot("g1"), np.random.default_rng(seed)
    arms = UpperBody.of(one).both_arms()
    collision = SelfCollisionLimit(one)
    ik = wbc.InverseKinematics(
        one,
        joints=[one.joint_names[j] for arm in arms for j in arm.joints],
        limits=[wbc.JointPositionLimit(one), wbc.JointVelocityLimit(one), collision],
    )
    for arm in arms:
        ik.add(wbc.PositionTask(arm.hand, random.uniform([-0.1, -0.2, 0.7], [0.3, 0.2, 1.2])))
    q = one.q_nominal.copy()
    for _ in range(100):
        q = pin.integrate(one.model, q, 0.01 * ik.step(q, 0.01))
        # The least distance that the limit saw; pairs that are not near are not in it.
        assert min(collision.distances.values(), default=1.0) > 0.005
    assert collision.pairs.least_distance(q)[0] > 0.005


def test_the_controller_keeps_bodies_apart_too_and_its_copies_go_on_alike():
    one = robot("g1")
    arms = UpperBody.of(one).both_arms()
    collision = SelfCollisionLimit(one)
    controller = wbc.WholeBodyController(one)
    controller.set_limits([*controller.limits, collision])
    controller.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in one.soles])
    controller.add(wbc.ComTask())
    controller.add(wbc.PostureTask(one))
    for arm in arms:
        controller.add(wbc.PositionTask(arm.hand, (0.2, 0.0, 0.9), weight=30.0, kp=30.0))
    state, least = one.standing(), np.inf
    for _ in range(300):
        command = controller.step(state)
        v = state.v + controller.dt * command.acceleration
        state = wbc.State(pin.integrate(one.model, state.q, controller.dt * v), v)
        least = min(least, min(collision.distances.values()))
    assert command.status is wbc.command.Status.OK
    assert 0.0 < least < 0.015
    tau = copy.deepcopy(controller).step(state).tau
    assert (tau == controller.step(state).tau).all()


def test_a_search_finds_postures_without_collisions_or_tells_which_bodies_are_in_the_way():
    one = robot("g1")
    arms = UpperBody.of(one).both_arms()
    collision = SelfCollisionLimit(one)
    ik = wbc.InverseKinematics(
        one,
        joints=[one.joint_names[j] for arm in arms for j in arm.joints],
        limits=[wbc.JointPositionLimit(one), collision],
    )
    left, right = (ik.add(wbc.PositionTask(arm.hand, (0.3, 0.0, 0.9))) for arm in arms)
    found = ik.reach(one.q_nominal, restarts=1)
    assert not found.reached
    assert "self-collision limit [" in found.explanation
    left.target, right.target = np.array([0.3, 0.15, 0.9]), np.array([0.3, -0.15, 1.0])
    found = ik.reach(one.q_nominal)
    assert found.reached
    assert collision.pairs.least_distance(found.q)[0] > 0.004


def test_arguments_are_checked():
    one = robot("g1")
    with pytest.raises(LimitError, match="margin"):
        SelfCollisionLimit(one, margin=0.2)
    with pytest.raises(LimitError, match="gain"):
        SelfCollisionLimit(one, gain=0.0)
    with pytest.raises(LimitError, match="recovery"):
        SelfCollisionLimit(one, recovery=-1.0)


@given(seed=seeds)
@settings(max_examples=6)
def test_no_near_pair_is_left_out_before_its_distance_is_computed(seed):
    one = robot(("g1", "talos")[seed % 2])
    limit, state = SelfCollisionLimit(one), random_state(one, seed, spread=0.5)
    found = {k: d for d, k, *_ in limit._near.update(wbc.Kinematics(one, state), 0.06)}
    distances = SelfCollision.of(one).distances(state.q)
    assert set(found) == set(np.flatnonzero(distances < 0.06))
    for k, d in found.items():
        assert d == pytest.approx(distances[k], abs=1e-6)


def test_a_hand_keeps_its_distance_from_obstacles_also_when_they_move():
    panda = wbc.load_fixed_base("panda")
    ik = wbc.InverseKinematics(panda)
    hand = ik.add(wbc.PositionTask("panda_hand"))
    ik.step(panda.q_nominal, 0.01)
    start = hand.target.copy()
    wall = coal.Box(0.02, 2.0, 2.0)
    at = pin.SE3(np.eye(3), np.array([start[0] + 0.2, 0.0, 0.5]))
    limit = ObstacleLimit(panda, {"wall": (wall, at)}, margin=0.02)
    ik.set_limits([*ik.limits, limit])
    hand.target = start + np.array([0.3, 0.0, 0.0])
    q = panda.q_nominal.copy()

    def least(steps: int) -> float:
        nonlocal q, ik
        found = np.inf
        for _ in range(steps):
            q = pin.integrate(panda.model, q, 0.01 * ik.step(q, 0.01))
            found = min(found, min(limit.distances.values(), default=np.inf))
        return found

    assert 0.015 < least(200) < 0.022
    assert "wall" in next(iter(limit.distances))
    other = pickle.loads(pickle.dumps(ik))
    assert (other.step(q, 0.01) == ik.step(q, 0.01)).all()
    other.limits[-1].place("wall", at * pin.SE3(np.eye(3), np.array([1.0, 0.0, 0.0])))
    assert not other.limits[-1].distances or (other.step(q, 0.01) != ik.step(q, 0.01)).any()
    for k in range(100):  # 5 cm/s towards the arm
        limit.place("wall", pin.SE3(np.eye(3), at.translation - [0.0005 * k, 0.0, 0.0]))
        q = pin.integrate(panda.model, q, 0.01 * ik.step(q, 0.01))
    assert min(limit.distances.values()) > 0.01


@pytest.mark.parametrize(
    ("obstacles", "options", "text"),
    [
        ({}, {}, "0 obstacles"),
        ({"floor": (coal.Halfspace(), pin.SE3.Identity())}, {}, "'floor'"),
        ({"ball": (coal.Sphere(0.1), pin.SE3.Identity())}, {"margin": 0.3}, "detection distance"),
        ({"ball": (coal.Sphere(0.1), pin.SE3.Identity())}, {"bodies": []}, "0 shapes of the robot"),
    ],
)
def test_obstacles_are_checked(obstacles, options, text):
    with pytest.raises(LimitError, match=text):
        ObstacleLimit(wbc.load_fixed_base("panda"), obstacles, **options)


def test_an_obstacle_that_is_moved_must_exist():
    ball = {"ball": (coal.Sphere(0.1), pin.SE3.Identity())}
    limit = ObstacleLimit(wbc.load_fixed_base("panda"), ball)
    with pytest.raises(LimitError, match=r"no obstacle 'bal'.*did you mean 'ball'"):
        limit.place("bal", pin.SE3.Identity())


class Pinched(wbc.limits.BarrierLimit):
    """The hand is between two walls that are nearer to each other than it is thick."""

    def __init__(self, frame: str) -> None:
        super().__init__("pinch", 2, labels=("left", "right"))
        self.frame = frame

    def write_barrier(self, kin: wbc.Kinematics, barrier: BarrierRows) -> None:
        across = kin.jacobian(self.frame)[1]
        barrier.h[:] = -0.01
        barrier.J[:] = across, -across


def test_a_pinched_hand_leaves_the_controller_and_inverse_kinematics_a_solution():
    one = robot("talos")
    pinch = Pinched(UpperBody.of(one).both_arms()[0].hand)
    controller = wbc.WholeBodyController(one)
    controller.set_limits([*controller.limits, pinch])
    controller.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in one.soles])
    com = controller.add(wbc.ComTask())
    controller.add(wbc.PostureTask(one))
    state = one.standing()
    for _ in range(3):
        command = controller.step(state)
        assert command.status is wbc.Status.OK, command.explanation
        assert "pinch [left] by" in command.explanation
        assert "pinch [right] by" in command.explanation
        assert np.abs(command.tau).max() > 1.0
    com.priority, controller.tasks[-1].priority = 1, 2
    assert controller.step(state).status is wbc.Status.OK
    controller.set_limits(controller.limits[:-1])
    command = controller.step(state)
    assert command.status is wbc.Status.OK
    assert not command.explanation
    ik = wbc.InverseKinematics(one)
    ik.set_limits([*ik.limits, pinch])
    assert np.isfinite(ik.step(one.q_nominal, 0.01)).all()
