"""Every QP solver that is installed, on the QPs of a controller that sways Talos on two feet.

Two recordings, each in the full formulation (unknowns v̇ and all forces) and in the reduced one
(base acceleration and stance wrench eliminated):

- easy: a slow sway, hardly a row is active;
- hard: torque limits × 0.3, friction 0.2, a fast motion at the limits.

Each solver gets the problems one after another through the library's own adapters, as a
controller would hand them over, so that what can start warm does. The time is the CPU time of
`Solver.solve`, of each problem the least of several passes. Solvers reached through `qpsolvers`
pay for conversion: rows are stacked and split into one-sided ones, some make them sparse, and all
set up afresh each time. Of that time, what `qpsolvers` says the solver itself took is given as
`inside`. "wbc", "daqp" and "osqp" are called directly, with a workspace that they keep.

What is found is measured against optima proved in extended precision (`tests/certified_qp.py`):

- row off: worst violation of a row, relative to the row's norm;
- slope: what is left of the cost's gradient along the rows active at the optimum, relative;
- x off: largest error of an unknown (m/s², rad/s², forces in units of the robot's weight);
- failed: problems that the solver gave up on. All of them have a solution.

Iterative solvers are asked for 1e-9 (SCS, which does not get there, for 1e-6).

    python benchmarks/solvers.py --plot solvers.png --json solvers.json
    python benchmarks/solvers.py --solver default --solver daqp --ticks 50
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import gc
import json
import sys
import time
import warnings
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "tools"))
from certified_qp import Optimum, optimum
from shared.sway_recording import Motion, record
from unreduced_qp import UnreducedQP

import wbc
from wbc.qp import Outcome, Problem, Solution, Solver, make_solver
from wbc.qp.solvers.qpsolvers import QpsolversSolver

SLOW = 3000.0  # µs; solvers that take longer get one pass
DIRECT = ("wbc", "daqp", "osqp")
OPTIONS: dict[str, dict[str, Any]] = {
    "proxqp": {"eps_abs": 1e-9, "eps_rel": 0.0},
    "piqp": {"eps_abs": 1e-9, "eps_rel": 1e-9},
    "clarabel": {"tol_gap_abs": 1e-9, "tol_gap_rel": 1e-9, "tol_feas": 1e-9},
    "scs": {"eps_abs": 1e-6, "eps_rel": 1e-6},
}


MOTIONS = {
    "easy": Motion((0.005, 0.02, 0.005), 0.5, 0.05),
    "hard": Motion((0.01, 0.02, 0.01), 1.0, 0.2, torque=0.3, friction=0.2),
}


@dataclass
class SolverResult:
    """The results of one solver on one set of problems."""

    solver: str
    formulation: str
    states: str
    p50_us: float
    p99_us: float
    inside_us: float | None
    row_off: float
    slope: float
    x_off: float
    failed: int


def installed() -> list[str]:
    """Return the installed solvers, the default one first."""
    import qpsolvers

    own = make_solver().name
    names = [own, *(name for name in DIRECT if name != own)]
    return names + [name for name in sorted(qpsolvers.available_solvers) if name not in names]


def solver_of(name: str) -> Solver:
    """Return a new instance of a solver.

    Raises:
        SolverNotFound: unknown or not installed.
    """
    return make_solver(name, **({} if name in DIRECT else OPTIONS.get(name, {})))


def certified(problem: Problem) -> Optimum:
    """Return the certified optimum of a QP.

    Raises:
        RuntimeError: No optimum was found.
    """
    n = problem.g.size
    eigenvalues, V = np.linalg.eigh(problem.H)
    kept = eigenvalues > 1e-13 * eigenvalues[-1]
    root = np.sqrt(eigenvalues[kept])
    G, d = root[:, None] * V[:, kept].T, -(V[:, kept].T @ problem.g) / root
    A = np.vstack((np.eye(problem.bounded, n), problem.C))
    norm = np.maximum(np.linalg.norm(A, axis=1), 1e-12)
    A, low, high = A / norm[:, None], problem.lb / norm, problem.ub / norm
    same = low == high
    free = ~same & (np.isfinite(low) | np.isfinite(high))
    rows = UnreducedQP(
        *(np.ones(n), G, d, A[same], low[same], A[free], low[free], high[free]),
        *(norm[same], norm[free], (n, 0, 0), []),
    )
    found = optimum(rows)
    if found is None:
        raise RuntimeError("a recorded problem has no certified optimum")
    return found


def run(name: str, problems: Sequence[Problem], passes: int) -> Any:
    """Return the smallest total and inner times, µs, and the solutions of the last pass."""
    best, inner = np.full(len(problems), np.inf), np.full(len(problems), np.inf)
    solutions: list[Solution] = []
    clock = time.process_time_ns
    # qpsolvers measures wall time; here its clock is replaced by the CPU clock.
    with patch.object(time, "perf_counter", time.process_time):
        for _ in range(passes):
            solver = solver_of(name)
            solver.solve(problems[0])  # makes what is made once
            solutions = []
            gc.collect()
            gc.disable()
            for k, problem in enumerate(problems):
                begun = clock()
                solutions.append(solver.solve(problem))
                best[k] = min(best[k], 1e-3 * (clock() - begun))
                if isinstance(solver, QpsolversSolver):
                    inner[k] = min(inner[k], 1e6 * solver.solve_time)
            gc.enable()
            if np.median(best) > SLOW:
                break
    return best, inner if np.isfinite(inner).all() else None, solutions


def measure_solver(
    name: str,
    formulation: str,
    states: str,
    problems: Sequence[Problem],
    passes: int,
    optima: Sequence[Optimum],
) -> SolverResult:
    """Time a solver and compare its solutions with the certified optima."""
    times, inner, solutions = run(name, problems, passes)
    row_off = slope = x_off = 0.0
    failed = 0
    for problem, solution, best in zip(problems, solutions, optima, strict=True):
        if solution.outcome is not Outcome.SOLVED:
            failed += 1
            continue
        norm = np.ones(problem.lb.size)
        norm[problem.bounded :] = np.maximum(np.linalg.norm(problem.C, axis=1), 1e-12)
        row_off = max(row_off, float((problem.violation(solution.x) / norm).max()))
        gradient = problem.H @ solution.x + problem.g
        along = np.abs(best.free.T @ gradient).max() / np.abs(problem.g).max()
        slope = max(slope, float(along))
        x_off = max(x_off, float(np.abs(solution.x - best.x).max()))
    inside = None if inner is None else float(np.median(inner))
    p50, p99 = float(np.median(times)), float(np.percentile(times, 99))
    return SolverResult(name, formulation, states, p50, p99, inside, row_off, slope, x_off, failed)


def conclusion(found: Sequence[SolverResult], default: str) -> str:
    """Return a text that names the default solver and justifies it by the figures."""
    lines = []
    reduced = [f for f in found if f.formulation == "reduced"]
    for states in MOTIONS:
        here = [f for f in reduced if f.states == states]
        mine = next((f for f in here if f.solver == default), None)
        sound = [f for f in here if not f.failed and f.x_off < 1e-6 and f.row_off < 1e-8]
        if mine is None or not sound:
            continue
        others = [f for f in sound if f.solver != default]
        text = f"{states}, reduced: '{default}' takes {mine.p50_us:.0f} µs at the median"
        if mine not in sound:
            text += f", but is off by {mine.x_off:.1e} or fails ({mine.failed})"
        if others:
            next_best = min(others, key=lambda f: f.p50_us)
            ratio = next_best.p50_us / mine.p50_us
            word = "the next" if ratio >= 1.0 else "a faster one"
            text += f"; {word} that is as right (x within 1e-6, rows within 1e-8, no failure)"
            text += f" is '{next_best.solver}' with {next_best.p50_us:.0f} µs ({ratio:.1f} ×)"
        lines.append(text + ".")
    for name in dict.fromkeys((default, *(f.solver for f in found))):
        full = {f.states: f.p50_us for f in found if (f.solver, f.formulation) == (name, "full")}
        less = {f.states: f.p50_us for f in reduced if f.solver == name}
        ratios = ", ".join(f"{full[s] / less[s]:.1f} ({s})" for s in full if s in less)
        lines.append(f"Full over reduced, {name}: {ratios}.")
    lines.append(
        f"The default is '{default}': a controller needs all its digits every tick, so the choice "
        "is among the active-set methods; of these it takes the one that is called directly, keeps "
        "its working set from tick to tick, and transforms only the rows in it."
        if default == "wbc"
        else f"The default here is '{default}', since no kernels can be compiled on this machine."
    )
    return "\n".join(lines)


def plot(found: Sequence[SolverResult], path: Path) -> None:
    """Medians as bars with marks at the 99th percentile; one panel for easy, one for hard."""
    try:
        import matplotlib
    except ImportError as error:
        raise SystemExit("--plot needs matplotlib: pip install 'wbc[plots]'") from error
    matplotlib.use("Agg")
    from matplotlib import pyplot

    fast = {f.solver: f.p50_us for f in found if (f.formulation, f.states) == ("reduced", "hard")}
    solvers = sorted(fast, key=lambda s: -fast[s])
    figure, axes = pyplot.subplots(1, 2, figsize=(11.0, 4.2), layout="constrained", sharey=True)
    for ax, states in zip(axes, MOTIONS, strict=True):
        for shift, formulation, color in ((0.2, "reduced", "C0"), (-0.2, "full", "C1")):
            for row, solver in enumerate(solvers):
                key = (solver, formulation, states)
                f = next(f for f in found if (f.solver, f.formulation, f.states) == key)
                label = formulation if row == 0 else None
                ax.barh(row + shift, f.p50_us, 0.36, color=color, label=label)
                ax.plot([f.p50_us, f.p99_us], [row + shift] * 2, color="0.3", lw=1)
                if f.inside_us:
                    ax.plot([f.inside_us] * 2, [row + shift - 0.17, row + shift + 0.17], "w", lw=2)
                note = f"{f.p50_us:.0f}" + (f"  x off {f.x_off:.0e}" if f.x_off > 1e-6 else "")
                note += f"  {f.failed} failed" if f.failed else ""
                ax.text(f.p99_us * 1.1, row + shift, note, va="center", fontsize=7)
        ax.set(xscale="log", xlabel="µs per solve (line to the 99th percentile)", title=states)
        ax.set_yticks(range(len(solvers)), solvers)
        ax.set_xlim(0.5 * min(f.p50_us for f in found), 100.0 * max(f.p99_us for f in found))
        ax.grid(axis="x", alpha=0.3)
    axes[0].legend(fontsize=8, loc="lower right")
    figure.supxlabel("white mark: what the solver itself takes of a call through qpsolvers", size=8)
    figure.savefig(path, dpi=150)


def main() -> None:
    """Record, solve and assess, print the tables, and write the JSON file and the plot."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robot", default="talos")
    parser.add_argument("--ticks", type=int, default=100, help="recorded (default: %(default)s)")
    parser.add_argument("--passes", type=int, default=5, help="of each (default: %(default)s)")
    parser.add_argument("--solver", action="append", help="only this one; default: all there are")
    parser.add_argument("--plot", type=Path, help="draw it there (needs matplotlib)")
    parser.add_argument("--json", type=Path, help="write the tables there")
    args = parser.parse_args()
    warnings.filterwarnings("ignore", module="qpsolvers")
    robot = wbc.load(args.robot)
    default = make_solver().name
    names = [default if s == "default" else s for s in args.solver] if args.solver else installed()
    formulations = {"reduced": wbc.Formulation.REDUCED, "full": wbc.Formulation.FULL}
    found: list[SolverResult] = []
    for states, motion in MOTIONS.items():
        problems = record(robot, motion, args.ticks, list(formulations.values()))
        for text, formulation in formulations.items():
            some = problems[formulation]
            optima = [certified(problem) for problem in some]
            active = np.mean([len(o.active) for o in optima])
            rows = some[0].C.shape[0]
            print(f"{states}, {text}: {some[0].g.size} unknowns, {rows} rows and", end=" ")
            print(f"{some[0].bounded} bounds, {active:.1f} active inequalities at the mean")
            head = ("p50 µs", "p99 µs", "inside", "row off", "slope", "x off", "failed")
            print(f"{'':<10}" + "".join(f"{h:>10}" for h in head))
            for name in names:
                f = measure_solver(name, text, states, some, args.passes, optima)
                found.append(f)
                inside = "" if f.inside_us is None else f"{f.inside_us:.0f}"
                print(f"{name:<10}{f.p50_us:>10.1f}{f.p99_us:>10.1f}{inside:>10}", end="")
                print(f"{f.row_off:>10.1e}{f.slope:>10.1e}{f.x_off:>10.1e}{f.failed:>10}")
            print()
    print(conclusion(found, default))
    if args.plot:
        plot(found, args.plot)
    if args.json:
        text = {"robot": robot.name, "default": default, "found": [asdict(f) for f in found]}
        args.json.write_text(json.dumps(text, indent=2) + "\n")


if __name__ == "__main__":
    main()
