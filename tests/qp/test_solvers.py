"""All solvers find the same optimum; failures are failures, not numbers."""

import sys
from pathlib import Path

import numpy as np
import pytest
from coretools import controller, few, force_of, robot, robots, seeds, standing_state
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import nnls

import wbc
from wbc.command import Status
from wbc.errors import SolverNotFound
from wbc.qp import Outcome, Problem, make_solver
from wbc.qp.rows import RowBlock

EXACT = {"proxqp": {"eps_abs": 1e-10}, "quadprog": {}}  # these reach 1e-7, and their options


def installed() -> list[str]:
    import qpsolvers

    return [name for name in EXACT if name in qpsolvers.available_solvers]


def problem_of(control: wbc.WholeBodyController, state: wbc.State) -> Problem:
    control.step(state)
    assert control.problem is not None
    return control.problem


@few
@given(robots, st.sampled_from(("none", "left", "both", "left exact, right soft", "points")), seeds)
def test_daqp_agrees_with_proxqp_and_quadprog_where_installed(name, contacts, seed):
    bot = robot(name)
    state = standing_state(bot, seed)
    control = controller(bot, contacts)
    reference = control.step(state)
    assert reference.status is Status.OK
    assembly = control._assembly()
    for other in installed():
        solution = make_solver(other, **EXACT[other]).solve(control.problem)
        assert solution.outcome is Outcome.SOLVED, solution.detail
        command = assembly.recover(solution.x, control.kinematics, control.dt)
        np.testing.assert_allclose(
            reference.acceleration, command.acceleration, atol=1e-7, err_msg=other
        )
        for contact in control.contacts:
            force = command.wrenches[contact.name][: contact.motion_size]
            np.testing.assert_allclose(force_of(contact, reference), force, atol=1e-6)


@pytest.mark.parametrize("contacts", ["none", "left", "both", "left exact, right soft"])
def test_daqp_meets_the_optimality_conditions_to_rounding(contacts):
    bot = robot("talos")
    for seed in range(10):
        control = controller(bot, contacts)
        problem = problem_of(control, standing_state(bot, seed, speed=0.4))
        x = control.solver.solve(problem).x
        assert problem.violation(x).max() < 1e-8
        rows = np.vstack((np.eye(problem.bounded, x.size), problem.C))
        y = problem.values(x)
        upper = np.abs(y - problem.ub) < 1e-6
        lower = np.abs(y - problem.lb) < 1e-6
        # Some active rows may be redundant: look for any multipliers of the right sign.
        sides = np.vstack((rows[upper], -rows[lower]))
        gradient = problem.H @ x + problem.g
        residual = nnls(sides.T, -gradient)[1] if sides.size else np.linalg.norm(gradient)
        assert residual < 1e-7 * np.abs(problem.g).max()


def test_osqp_reuses_its_workspace_within_its_tolerance():
    bot = robot("simple_humanoid")
    ours, osqp = controller(bot, "both"), controller(bot, "both", solver="osqp")
    for seed in range(4):
        state = standing_state(bot, seed)
        for task in (*ours.tasks[:2], *osqp.tasks[:2]):
            task.target = None
        a, b = ours.step(state), osqp.step(state)
        assert b.status is Status.OK, b.explanation
        np.testing.assert_allclose(a.tau, b.tau, atol=0.02)
        np.testing.assert_allclose(a.acceleration, b.acceleration, atol=0.02)
    assert len(osqp.solver._workspaces) == 1


@pytest.mark.parametrize("solver", ["daqp", "osqp", *EXACT])
def test_a_solver_reports_an_infeasible_problem_and_solves_the_next(solver):
    if solver not in ("daqp", "osqp", *installed()):
        pytest.skip(f"{solver} is not installed")
    chosen = make_solver(solver)
    good = little_problem(lb=[-1.0, 0.0, -np.inf], ub=[1.0, 2.0, 3.0])
    bad = little_problem(lb=[-1.0, 0.0, 5.0], ub=[1.0, 2.0, 6.0])
    for _ in range(2):
        assert chosen.solve(good).outcome is Outcome.SOLVED
        assert chosen.solve(bad).outcome is not Outcome.SOLVED
    np.testing.assert_allclose(chosen.solve(good).x, [1.0, 2.0], atol=1e-5)


def test_bounds_that_coincide_for_some_ticks_become_inequalities_again():
    """DAQP marks a row whose bounds are equal as an equality; it must forget that."""
    chosen = make_solver("daqp")
    for lb, ub, x in (([-9, -9], [9, 9], 5.0), ([1, -9], [1, 9], 1.0), ([-9, -9], [9, 9], 5.0)):
        problem = little_problem(lb=[*lb, -np.inf], ub=[*ub, np.inf])
        np.testing.assert_allclose(chosen.solve(problem).x, [x, 5.0], atol=1e-8)


@pytest.mark.parametrize("scale", [1e-8, 1.0, 1e8])
def test_daqp_solution_does_not_depend_on_the_scale_of_the_cost(scale):
    """Its tolerances are absolute: heavy tasks must not make it overlook a light row."""
    problem = little_problem(lb=[-np.inf, -np.inf, -1.0], ub=[np.inf, np.inf, 1.0])
    problem.C *= 1e-3
    problem.lb[2:] *= 1e-3
    problem.ub[2:] *= 1e-3
    problem.H *= scale
    problem.g *= scale
    np.testing.assert_allclose(make_solver("daqp").solve(problem).x, [0.5, 0.5], atol=1e-6)


def test_daqp_solves_a_problem_with_a_singular_cost():
    problem = little_problem(lb=[-1.0, -1.0, -np.inf], ub=[1.0, 1.0, np.inf])
    problem.H[1, 1] = 0.0
    solution = make_solver("daqp").solve(problem)
    assert solution.outcome is Outcome.SOLVED
    np.testing.assert_allclose(solution.x, [1.0, 1.0], atol=1e-6)


def little_problem(lb: list[float], ub: list[float]) -> Problem:
    """min ½|x − (5, 5)|² with bounds on both variables and on their sum."""
    blocks = (RowBlock("box", "m", 0, 2), RowBlock("sum", "m", 2, 3))
    return Problem(
        np.eye(2),
        np.array([-5.0, -5.0]),
        np.array([[1.0, 1.0]]),
        np.array(lb, dtype=float),
        np.array(ub, dtype=float),
        2,
        np.zeros(3, dtype=bool),
        blocks,
    )


def test_an_unknown_solver_is_refused_with_near_names():
    with pytest.raises(SolverNotFound, match=r"'dapq'.*did you mean 'daqp'.*pip install"):
        wbc.WholeBodyController(robot("talos"), solver="dapq")


def test_missing_osqp_is_an_error_with_its_pip_command(monkeypatch):
    monkeypatch.setitem(sys.modules, "osqp", None)
    with pytest.raises(SolverNotFound, match=r"'osqp' needs 'osqp'.*pip install osqp"):
        make_solver("osqp")


def test_a_problem_on_which_daqp_cycles_is_solved():
    # Recorded from G1 walking sideways, at the end of a weight transfer: the leaving foot may
    # bear 1 N at the most, and its cone's rows all but coincide.
    stored = np.load(Path(__file__).parents[1] / "data" / "cycling_qp.npz")
    rows = stored["ub"].size
    problem = Problem(
        **{name: stored[name] for name in ("H", "g", "C", "lb", "ub", "equality")},
        bounded=int(stored["bounded"]),
        blocks=(RowBlock("all", "1", 0, rows),),
    )
    found, other = make_solver("daqp").solve(problem), make_solver("osqp").solve(problem)
    assert found.outcome is other.outcome is Outcome.SOLVED

    def cost(x):
        return 0.5 * x @ problem.H @ x + problem.g @ x

    assert problem.violation(found.x).max() < 1e-8
    assert cost(found.x) <= cost(other.x) + 1e-6 * abs(cost(other.x))
