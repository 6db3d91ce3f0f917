"""A controller takes a solver by its name or as an object, and trusts no answer unseen."""

import numpy as np
import pytest
from coretools import controller, robot, standing_state

import wbc
from wbc.command import Status
from wbc.errors import WbcError
from wbc.qp import Outcome, Problem, Solution, make_solver


class Altered:
    """DAQP, whose solution is handed on as `alter` returns it."""

    def __init__(self, alter):
        self.alter = alter
        self.inner = make_solver("daqp")

    def solve(self, problem: Problem) -> Solution:
        found = self.inner.solve(problem)
        return Solution(self.alter(found.x), found.outcome)


def read_only(x):
    x.setflags(write=False)
    return x


FORMULATIONS = pytest.mark.parametrize("formulation", list(wbc.Formulation))


@FORMULATIONS
@pytest.mark.parametrize(
    ("alter", "tolerance"),
    [
        (lambda x: x, 1e-9),
        (read_only, 1e-9),
        (lambda x: x.astype(np.float32), 1e-2),
        (lambda x: np.repeat(x, 2)[::2], 1e-9),
        (list, 1e-9),
    ],
    ids=["an array", "read-only", "float32", "strided", "a list"],
)
def test_solutions_in_any_array_layout_or_precision_are_used(formulation, alter, tolerance):
    bot = robot("talos")
    state = standing_state(bot, 5)
    own = controller(bot, "both", solver=Altered(alter), formulation=formulation).step(state)
    assert own.status is Status.OK, own.explanation
    theirs = controller(bot, "both", formulation=formulation).step(state)
    np.testing.assert_allclose(own.tau, theirs.tau, atol=tolerance)


@FORMULATIONS
@pytest.mark.parametrize(
    ("alter", "detail"),
    [
        (lambda x: np.full_like(x, np.nan), "not finite"),
        (lambda x: x[:-1], "of shape"),
        (lambda x: x[:1], "of shape"),
    ],
    ids=["NaN", "too short", "one number"],
)
def test_an_invalid_solution_of_a_solver_leads_to_safe_torques(formulation, alter, detail):
    bot = robot("talos")
    control = controller(bot, "both", solver=Altered(alter), formulation=formulation)
    command = control.step(standing_state(bot, 5))
    assert command.status is Status.FAILED
    assert detail in command.explanation
    assert np.isfinite(command.tau).all()


def test_a_solver_that_fails_gives_its_reason():
    class Empty:
        def solve(self, problem):
            return Solution(np.zeros(problem.g.size), Outcome.FAILED, detail="out of iterations")

    bot = robot("talos")
    command = controller(bot, "both", solver=Empty()).step(bot.standing())
    assert command.status is Status.FAILED
    assert "out of iterations" in command.explanation


@pytest.mark.parametrize("solver", [42, object(), Altered], ids=["number", "object", "class"])
def test_an_object_that_is_no_solver_is_refused_with_the_protocol(solver):
    with pytest.raises(WbcError, match=r"neither a name nor an object.*solve\(problem\)"):
        wbc.WholeBodyController(robot("talos"), solver=solver)


@pytest.mark.parametrize(
    ("name", "tolerance"), [("piqp", 0.01), ("proxqp", 0.05), ("clarabel", 0.2), ("scs", 50.0)]
)
def test_solvers_of_qpsolvers_drive_the_compiled_controller(name, tolerance):
    import qpsolvers

    if name not in qpsolvers.available_solvers:
        pytest.skip(f"{name} is not installed")
    bot = robot("talos")
    state = standing_state(bot, 5)
    compiled = wbc.Formulation.COMPILED
    command = controller(bot, "both", solver=name, formulation=compiled).step(state)
    assert command.status is Status.OK, command.explanation
    reference = controller(bot, "both", formulation=compiled).step(state)
    np.testing.assert_allclose(command.tau, reference.tau, atol=tolerance)
