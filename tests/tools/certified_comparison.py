"""Runs controllers through random cases and compares every tick with the certified optimum."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from functools import cache

import numpy as np
from certified_qp import Infeasibility, Optimum, infeasibility, optimum
from random_cases import Case, CaseRunner
from unreduced_qp import UnreducedQP, unreduced_qp

import wbc
from wbc.command import Status
from wbc.qp import Problem

MAX_ERROR = 1e-6  # of each acceleration and each wrench, relative to max(1, |reference|)
MAX_VIOLATION = 1e-8  # violation of a row, relative to its scale
MAX_COST_EXCESS = 1e-8  # excess of the cost, and its slope along the active rows, both relative
MAX_ROUNDING = 1e-6  # rounding that moves the optimum further makes a problem ill-conditioned
CLEARLY_INFEASIBLE = 1e-6  # violation of unit rows that no tolerance hides


class ProblemClass(Enum):
    """What has been certified about a problem."""

    SOLVABLE = "solvable"  #: the optimum is certified
    ILL_CONDITIONED = "ill-conditioned"  #: certified, but rounding of H and g may move it by > 1e-6
    INFEASIBLE = "infeasible"  #: certified by multipliers
    MARGINAL = "marginal"  #: rows conflict by less than CLEARLY_INFEASIBLE: either result passes
    UNCERTIFIED = "uncertified"  #: neither was certified


@dataclass
class Reference:
    """The certified solution of one tick."""

    problem_class: ProblemClass
    rows: UnreducedQP
    optimum: Optimum | None
    infeasibility: Infeasibility | None


@dataclass
class Comparison:
    """One tick of a controller compared with the certified solution.

    Attributes:
        acceleration, wrench, torque: largest error of an acceleration, of a contact's wrench and
            of a torque, relative to max(1, |reference|).
        violation: of the worst row of the unreduced problem, relative to its scale.
        excess: of the cost, relative to the least one.
        slope: of the cost along the active rows, relative to its terms (the KKT residual).
        fault: what is wrong; empty when nothing is.
    """

    case: Case
    tick: int
    problem_class: ProblemClass
    status: Status
    acceleration: float = 0.0
    wrench: float = 0.0
    torque: float = 0.0
    violation: float = 0.0
    excess: float = 0.0
    slope: float = 0.0
    fault: str = ""


def reference(rows: UnreducedQP, guess: dict[int, int] | None = None) -> Reference:
    """Certify the solution of one problem."""
    found = optimum(rows, guess)
    if found is not None:
        off = np.abs(found.attainable * rows.scale).max()
        exact = off <= MAX_ROUNDING
        problem_class = ProblemClass.SOLVABLE if exact else ProblemClass.ILL_CONDITIONED
        return Reference(problem_class, rows, found, None)
    least = infeasibility(rows)
    if least.violation > CLEARLY_INFEASIBLE and least.radius > 1e6:
        return Reference(ProblemClass.INFEASIBLE, rows, None, least)
    problem_class = (
        ProblemClass.UNCERTIFIED
        if least.violation < 1e-10 or least.violation > CLEARLY_INFEASIBLE
        else ProblemClass.MARGINAL
    )
    return Reference(problem_class, rows, None, least)


@cache
def references(case: Case) -> tuple[Reference, ...]:
    """Certify the solution of each tick of a case. The result is cached."""
    runner, found = CaseRunner(case), []
    guess = None
    for tick in range(case.ticks):
        runner.advance(tick)
        rows = unreduced_qp(runner.setup, runner.state)
        same = found and found[-1].rows.C.shape == rows.C.shape
        found.append(reference(rows, guess if same else None))
        guess = found[-1].optimum.active if found[-1].optimum is not None else None
    return tuple(found)


def compare_case(
    case: Case, solver: str | None = None, formulation: wbc.Formulation | None = None
) -> list[Comparison]:
    """Compare all ticks of a case; None takes the default solver or formulation."""
    return [comparison for comparison, _ in compare_ticks(case, solver, formulation)]


def compare_ticks(
    case: Case, solver: str | None = None, formulation: wbc.Formulation | None = None
) -> Iterator[tuple[Comparison, Problem | None]]:
    """Yield each tick's comparison and the controller's QP, which is valid until the next tick."""
    runner = CaseRunner(case)
    control = runner.controller(solver, formulation)
    for tick, known in enumerate(references(case)):
        runner.advance(tick)
        if control.contacts != tuple(runner.setup.contacts):
            control.set_contacts(runner.setup.contacts)
        yield compare(case, tick, known, control.step(runner.state)), control.problem


def compare(case: Case, tick: int, known: Reference, command: wbc.Command) -> Comparison:
    """Compare a command with the certified solution."""
    comparison = Comparison(case, tick, known.problem_class, command.status)
    if known.optimum is None:
        if known.problem_class is ProblemClass.INFEASIBLE:
            if command.status is not Status.INFEASIBLE:
                comparison.fault = f"infeasible, but status {command.status.name}"
            elif "these constraints conflict — " not in command.explanation:
                comparison.fault = f"no explanation of the conflict: '{command.explanation}'"
        return comparison
    if command.status is not Status.OK:
        comparison.fault = f"solvable, but status {command.status.name}: {command.explanation}"
        return comparison
    rows, best = known.rows, known.optimum
    x = rows.unknowns_of(command)
    want, off = best.x * rows.scale, np.abs(x - best.x) * rows.scale
    nv, nf, _ = rows.sizes
    comparison.acceleration = float((off / np.maximum(1.0, np.abs(want)))[:nv].max())
    comparison.torque = float((off / np.maximum(1.0, np.abs(want)))[nv + nf :].max())
    for _, part in rows.contacts:
        size = max(1.0, float(np.linalg.norm(want[nv : nv + nf][part])))
        comparison.wrench = max(comparison.wrench, float(off[nv : nv + nf][part].max()) / size)
    comparison.violation = rows.violation(x)
    least = rows.cost(best.x)
    comparison.excess = abs(rows.cost(x) - least) / max(least, 1e-12)
    gradient = rows.G.T @ (rows.G @ x - rows.d)
    terms = np.abs(rows.G).T @ (np.abs(rows.G @ x) + np.abs(rows.d))
    comparison.slope = float(
        np.abs(best.free.T @ gradient).max(initial=0.0) / max(terms.max(), 1e-300)
    )
    off_by = max(comparison.acceleration, comparison.wrench)
    if comparison.violation > MAX_VIOLATION:
        comparison.fault = f"a row is violated by {comparison.violation:.1e}"
    elif comparison.excess > MAX_COST_EXCESS or comparison.slope > MAX_COST_EXCESS:
        comparison.fault = (
            f"cost {comparison.excess:.1e} above the least, slope {comparison.slope:.1e}"
        )
    elif off_by > MAX_ERROR and known.problem_class is not ProblemClass.ILL_CONDITIONED:
        comparison.fault = (
            f"off by {comparison.acceleration:.1e} and {comparison.wrench:.1e} (wrenches)"
        )
    return comparison
