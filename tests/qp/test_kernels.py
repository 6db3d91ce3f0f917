"""The compiled kernels against numpy, Pinocchio and the optimality conditions."""

import subprocess
import sys
from functools import lru_cache

import numpy as np
import pinocchio as pin
import pytest
from coretools import robot, seeds, some
from hypothesis import given, settings
from hypothesis import strategies as st

import wbc
from wbc.limits import AccelerationBound
from wbc.qp import Formulation, Outcome, Problem, make_solver
from wbc.tasks import JointTask

ROBOTS = ("talos", "g1", "simple_humanoid")


class Stiffness(wbc.Task):
    """A task of somebody's own: two rows that mix joints."""

    unit = "rad/s²"

    def __init__(self, priority=1):
        super().__init__("stiffness", 2, 3.0, 10.0, None, priority)

    def write(self, kin, A, b):
        A[:] = 0.0
        A[0, 6:9] = (1.0, 2.0, -1.0)
        A[1, 10] = 1.0
        b[:] = -kin.state.q[7:9]


class Damping(JointTask):
    """A joint task of somebody's own."""

    unit = "rad/s²"

    def __init__(self, robot):
        super().__init__("damping", robot.na, 0.2, 0.0, None, 1)
        self.index = np.arange(robot.na)

    def write_joints(self, kin, b):
        b[:] = -5.0 * kin.state.v[6:]


class Lean(wbc.ComTask):
    """A library's task with rows of its own."""

    def write(self, kin, A, b):
        super().write(kin, A, b)
        b += 0.3


class Soft(wbc.SurfaceContact):
    """A contact with a motion of its own."""

    def write(self, kin, J, a):
        super().write(kin, J, a)
        a[2] -= 0.1


class Half(AccelerationBound):
    """A limit of somebody's own."""

    name = "half"

    def __init__(self, robot):
        super().__init__(0.05)
        self._size = robot.na

    def bounds(self, kin):
        room = np.full(self._size, 30.0) - 0.1 * np.abs(kin.state.v[6:])
        return -room, 0.5 * room


def random_state(bot, rng):
    """Near the nominal posture, moving."""
    step = np.concatenate((rng.normal(0.0, 0.2, 6), rng.normal(0.0, 0.15, bot.na)))
    q = pin.integrate(bot.model, bot.q_nominal, step)
    return wbc.State(q, rng.normal(0.0, 0.4, bot.nv))


def random_contacts(bot, kind):
    left, right = (wbc.SurfaceContact.from_sole(sole) for sole in bot.soles)
    if kind == "both exact":
        return [left, right]
    if kind == "one soft":
        right.motion_weight = 500.0
        return [right, left]
    if kind == "points":
        return [wbc.PointContact(sole.name, max_force=300.0) for sole in bot.soles]
    if kind == "own":
        sole = bot.soles[0]
        own = Soft(sole.name, sole.half_length, sole.half_width, name="own")
        return [own, right]
    return {"left": [left], "none": []}[kind]


CONTACTS = ("both exact", "one soft", "points", "own", "left", "none")


def random_tasks(bot, rng):
    left, right = bot.soles
    tasks = [
        wbc.ComTask(weight=rng.uniform(10, 1000), kp=40.0),
        wbc.PostureTask(bot, weight=rng.uniform(0.1, 2.0, bot.na)),
        wbc.OrientationTask(bot.torso, pin.exp3(rng.normal(0.0, 1.5, 3))),
        wbc.PositionTask(left.name, rng.normal(0.0, 0.5, 3), name="left position"),
        wbc.FrameTask(
            right.name,
            pin.SE3(pin.exp3(rng.normal(0.0, 1.0, 3)), rng.normal(0.0, 0.5, 3)),
            weight=rng.uniform(1, 9, 6),
        ),
        wbc.AngularMomentumTask(weight=0.01),
        Stiffness(),
        Damping(bot),
        Lean(name="lean", weight=7.0),
        wbc.OrientationTask(bot.base, name="exact", priority=0),
    ]
    chosen = [t for t in tasks if rng.random() < 0.6]
    for task in chosen:
        if hasattr(task, "velocity"):
            task.velocity = rng.normal(0.0, 0.5, np.shape(task.velocity))
            task.acceleration = rng.normal(0.0, 2.0, np.shape(task.acceleration))
    return chosen


@some
@given(st.sampled_from(ROBOTS), st.sampled_from(CONTACTS), seeds)
def test_compiled_kernels_equal_their_numpy_counterparts(name, contacts, seed):
    bot, rng = robot(name), np.random.default_rng(seed)
    limits = [wbc.TorqueLimit(bot), wbc.JointPositionLimit(bot), wbc.JointVelocityLimit(bot)]
    limits = [x for x in (*limits, Half(bot)) if rng.random() < 0.8]
    tasks, feet = random_tasks(bot, rng), random_contacts(bot, contacts)
    problems, commands = [], []
    states = [random_state(bot, rng) for _ in range(2)]
    for formulation in (Formulation.COMPILED, Formulation.REDUCED):
        control = wbc.WholeBodyController(bot, limits=limits, formulation=formulation)
        for task in tasks:
            control.add(task)
        control.set_contacts(feet)
        commands.append([control.step(state) for state in states])
        problems.append(control.problem)
    compiled, plain = problems
    for part in ("H", "g", "C", "lb", "ub"):
        got, wanted = getattr(compiled, part), getattr(plain, part)
        scale = np.abs(wanted[np.isfinite(wanted)]).max(initial=1.0)
        np.testing.assert_allclose(got / scale, wanted / scale, atol=1e-11, err_msg=part)
    assert compiled.blocks == plain.blocks
    for one, other in zip(*commands, strict=True):
        assert one.status is other.status
        if one.status is wbc.Status.OK:
            scale = max(1.0, np.abs(other.acceleration).max())
            np.testing.assert_allclose(one.acceleration, other.acceleration, atol=1e-6 * scale)
            np.testing.assert_allclose(one.tau, other.tau, atol=1e-5 * scale)
            np.testing.assert_allclose(one.q_target, other.q_target, atol=1e-9 * scale)
            assert one.wrenches.keys() == other.wrenches.keys()


@lru_cache
def log3_kernel():
    """A part of the kernels has no wrapper of its own: only kernels can call it."""
    import numba

    from wbc.qp.kernels.motion import log3

    return numba.njit(lambda R, S, out: log3(R, S, out))


@given(st.floats(0.0, np.pi - 1e-7), seeds)
@settings(max_examples=200)
def test_rotation_error_of_the_kernel_maps_one_rotation_to_the_other(angle, seed):
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    S = pin.exp3(rng.normal(size=3))
    R = pin.exp3(angle * axis / np.linalg.norm(axis)) @ S
    out = np.zeros(3)
    log3_kernel()(R, S, out)
    np.testing.assert_allclose(pin.exp3(out) @ S, R, atol=2e-7)
    assert np.linalg.norm(out) == pytest.approx(angle, abs=2e-7)


def random_problem(rng, n, rows, bounded, equalities, tight):
    """Convex, with a point that holds all rows; `tight` is the share of rows without slack."""
    A = rng.normal(size=(n + 3, n)) * 10.0 ** rng.uniform(-1, 1, n)
    C = rng.normal(size=(rows, n))
    if rows > 4:
        C[1] = 2.0 * C[0]  # redundant rows, as contacts have them
    total = bounded + rows
    x = rng.normal(size=n)
    y = np.concatenate((x[:bounded], C @ x))
    slack = lambda: np.where(rng.random(total) < tight, 0.0, rng.exponential(0.3, total))  # noqa: E731
    lb, ub = y - slack(), y + slack()
    lb[rng.random(total) < 0.3] = -np.inf
    ub[rng.random(total) < 0.3] = np.inf
    equal = np.zeros(total, dtype=bool)
    equal[total - equalities :] = True
    lb[equal] = ub[equal] = y[equal]
    blocks = ()
    return Problem(A.T @ A, 10.0 * rng.normal(size=n), C, lb, ub, bounded, equal, blocks)


def stationarity(problem, x):
    """How far −(H x + g) is from the cone of the active rows, by non-negative least squares."""
    from scipy.optimize import nnls

    A = np.vstack((np.eye(problem.bounded, x.size), problem.C))
    y = problem.values(x)
    near = 1e-6 * (1.0 + np.abs(y))
    normals = [A[y > problem.ub - near], -A[y < problem.lb + near]]
    force = -(problem.H @ x + problem.g)
    normals = np.vstack(normals)
    return (nnls(normals.T, force)[1] if len(normals) else np.linalg.norm(force)) / (
        1.0 + np.linalg.norm(problem.g) + np.linalg.norm(problem.H @ x)
    )


@some
@given(st.integers(2, 30), st.integers(0, 40), st.floats(0.0, 0.6), seeds)
def test_the_compiled_solver_meets_the_optimality_conditions(n, rows, tight, seed):
    rng = np.random.default_rng(seed)
    solver = make_solver("wbc")
    bounded = int(rng.integers(0, n + 1))
    equalities = int(rng.integers(0, min(rows, n // 2) + 1))
    for _ in range(4):  # problems that have nothing to do with the last one: the worst warm start
        problem = random_problem(rng, n, rows, bounded, equalities, tight)
        solution = solver.solve(problem)
        assert solution.outcome is Outcome.SOLVED
        assert problem.violation(solution.x).max(initial=0.0) < 1e-7
        assert stationarity(problem, solution.x) < 1e-6


@some
@given(st.integers(2, 20), seeds)
def test_compiled_solver_recognises_infeasible_rows(n, seed):
    rng = np.random.default_rng(seed)
    problem = random_problem(rng, n, 6, n, 0, 0.0)
    solver = make_solver("wbc")
    solver.solve(problem)
    row = problem.C[-1]
    problem.C[-2] = -row  # c x ≥ 1 and −c x ≥ 1
    problem.lb[-2:], problem.ub[-2:] = 1.0, np.inf
    assert solver.solve(problem).outcome is Outcome.INFEASIBLE


def test_without_numba_the_controller_runs_and_warns_of_the_cost():
    code = """
import sys, warnings
sys.modules["numba"] = None
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    import wbc
    robot = wbc.load("simple_humanoid")
    control = wbc.WholeBodyController(robot)
control.add(wbc.PostureTask(robot))
control.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in robot.soles])
print(control.step(robot.standing()).status.value, control.solver.name, control.formulation.value)
print([str(w.message) for w in caught if "pip install numba" in str(w.message)])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    first, second = done.stdout.splitlines()
    assert first == "ok daqp reduced"
    assert "nine times" in second
