"""The protocol of QP solvers."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from wbc.qp.problem import Problem, Solution


@runtime_checkable
class Solver(Protocol):
    """Solves one QP per tick; the problems of neighbouring ticks are similar.

    Any object with this method can be given to a controller as `solver=`.
    """

    def solve(self, problem: Problem) -> Solution:
        """Solve a problem.

        Args:
            problem: the QP. Its arrays are the controller's own and are overwritten in the next
                tick: copy what you keep, change nothing.

        Returns:
            The solution: x of shape (n,) with `Outcome.SOLVED`; otherwise
            `Outcome.INFEASIBLE` or `Outcome.FAILED` and the reason in `detail`. A problem
            without a solution is no reason to raise an exception.
        """


class NamedSolver(Solver, Protocol):
    """A solver of this library, which can be asked for by its name."""

    name: str
