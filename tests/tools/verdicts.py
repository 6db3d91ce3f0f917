"""Drives controllers through random cases and compares every tick with the proved optimum."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from functools import cache

import numpy as np
from certifiedqp import Conflict, Optimum, conflict, optimum
from randomcases import Case, Drive
from referencetools import Unreduced, unreduced

import wbc
from wbc.command import Status
from wbc.qp import Problem

ACCURACY = 1e-6  # of each acceleration and each contact's wrench, relative to max(1, |it|)
HELD = 1e-8  # violation of a row, relative to its scale
COST = 1e-8  # excess of the cost, and its slope along the active rows, both relative
DETERMINED = 1e-6  # where rounding alone may move the optimum further it is "ill-conditioned"
CLEAR = 1e-6  # least violation of unit rows from which on no tolerance hides a conflict


class Truth(Enum):
    """What has been proved about a problem."""

    SOLVABLE = "solvable"  #: the optimum is proved
    ILL_CONDITIONED = "ill-conditioned"  #: proved, but rounding of H and g may move it by > 1e-6
    INFEASIBLE = "infeasible"  #: proved by multipliers
    ON_THE_EDGE = "on the edge"  #: rows miss each other by less than CLEAR: both answers are right
    UNKNOWN = "unknown"  #: neither was proved


@dataclass
class Reference:
    """One tick's truth."""

    truth: Truth
    rows: Unreduced
    optimum: Optimum | None
    conflict: Conflict | None


@dataclass
class Verdict:
    """One tick of one controller against the truth.

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
    truth: Truth
    status: Status
    acceleration: float = 0.0
    wrench: float = 0.0
    torque: float = 0.0
    violation: float = 0.0
    excess: float = 0.0
    slope: float = 0.0
    fault: str = ""


def reference(rows: Unreduced, guess: dict[int, int] | None = None) -> Reference:
    """The truth about one problem."""
    found = optimum(rows, guess)
    if found is not None:
        off = np.abs(found.attainable * rows.scale).max()
        truth = Truth.SOLVABLE if off <= DETERMINED else Truth.ILL_CONDITIONED
        return Reference(truth, rows, found, None)
    rift = conflict(rows)
    if rift.violation > CLEAR and rift.radius > 1e6:
        return Reference(Truth.INFEASIBLE, rows, None, rift)
    truth = Truth.UNKNOWN if rift.violation < 1e-10 or rift.violation > CLEAR else Truth.ON_THE_EDGE
    return Reference(truth, rows, None, rift)


@cache
def references(case: Case) -> tuple[Reference, ...]:
    """The truth about each tick of a case; kept."""
    drive, found = Drive(case), []
    guess = None
    for tick in range(case.ticks):
        drive.advance(tick)
        rows = unreduced(drive.setup, drive.state)
        same = found and found[-1].rows.C.shape == rows.C.shape
        found.append(reference(rows, guess if same else None))
        guess = found[-1].optimum.active if found[-1].optimum is not None else None
    return tuple(found)


def verdicts(
    case: Case, solver: str | None = None, formulation: wbc.Formulation | None = None
) -> list[Verdict]:
    """A controller driven through a case; with the default solver and formulation when None."""
    return [verdict for verdict, _ in driven(case, solver, formulation)]


def driven(
    case: Case, solver: str | None = None, formulation: wbc.Formulation | None = None
) -> Iterator[tuple[Verdict, Problem | None]]:
    """Each tick's verdict, and the QP that the controller had; valid until the next."""
    drive = Drive(case)
    control = drive.controller(solver, formulation)
    for tick, known in enumerate(references(case)):
        drive.advance(tick)
        if control.contacts != tuple(drive.setup.contacts):
            control.set_contacts(drive.setup.contacts)
        yield assess(case, tick, known, control.step(drive.state)), control.problem


def assess(case: Case, tick: int, known: Reference, command: wbc.Command) -> Verdict:
    """Compare a command with the reference."""
    verdict = Verdict(case, tick, known.truth, command.status)
    if known.optimum is None:
        if known.truth is Truth.INFEASIBLE:
            if command.status is not Status.INFEASIBLE:
                verdict.fault = f"infeasible, but status {command.status.name}"
            elif "cannot hold" not in command.explanation:
                verdict.fault = f"no explanation of the conflict: '{command.explanation}'"
        return verdict
    if command.status is not Status.OK:
        verdict.fault = f"solvable, but status {command.status.name}: {command.explanation}"
        return verdict
    rows, best = known.rows, known.optimum
    x = rows.of(command)
    want, off = best.x * rows.scale, np.abs(x - best.x) * rows.scale
    nv, nf, _ = rows.sizes
    verdict.acceleration = float((off / np.maximum(1.0, np.abs(want)))[:nv].max())
    verdict.torque = float((off / np.maximum(1.0, np.abs(want)))[nv + nf :].max())
    for _, part in rows.contacts:
        size = max(1.0, float(np.linalg.norm(want[nv : nv + nf][part])))
        verdict.wrench = max(verdict.wrench, float(off[nv : nv + nf][part].max()) / size)
    verdict.violation = rows.violation(x)
    least = rows.cost(best.x)
    verdict.excess = abs(rows.cost(x) - least) / max(least, 1e-12)
    gradient = rows.G.T @ (rows.G @ x - rows.d)
    terms = np.abs(rows.G).T @ (np.abs(rows.G @ x) + np.abs(rows.d))
    verdict.slope = float(
        np.abs(best.free.T @ gradient).max(initial=0.0) / max(terms.max(), 1e-300)
    )
    off_by = max(verdict.acceleration, verdict.wrench)
    if verdict.violation > HELD:
        verdict.fault = f"a row is violated by {verdict.violation:.1e}"
    elif verdict.excess > COST or verdict.slope > COST:
        verdict.fault = f"cost {verdict.excess:.1e} above the least, slope {verdict.slope:.1e}"
    elif off_by > ACCURACY and known.truth is not Truth.ILL_CONDITIONED:
        verdict.fault = f"off by {verdict.acceleration:.1e} and {verdict.wrench:.1e} (wrenches)"
    return verdict
