"""The base of all solver adapters."""

from __future__ import annotations

from abc import ABC, abstractmethod

from wbc.qp.problem import Problem, Solution


class Solver(ABC):
    """Solves a sequence of similar problems; may keep a workspace between them."""

    name: str

    @abstractmethod
    def solve(self, problem: Problem) -> Solution:
        """Solve; never raises for a problem without a solution."""
