"""Checks the controller's solutions on thousands of random problems with certified optima.

Random robots (those of the catalogue and synthetic ones), states, contacts, tasks, weights and
limits; single ticks and warm-started sequences. The reference builds the unreduced problem, with
unknowns v̇, f and τ, from Pinocchio, and certifies its optimum in extended precision, or certifies
by multipliers that there is none (see `unreduced_qp.py` and `certified_qp.py` in `tests/tools`).

A tick is at fault when an acceleration or a contact's wrench is off by more than 1e-6 relative to
max(1, |reference|), a row of the unreduced problem is violated by more than 1e-8 of its scale,
the cost is more than 1e-8 above the least one, its slope along the active rows (the KKT residual)
is more than 1e-8 of its terms, a solvable problem is called infeasible, or an infeasible one
solved or not explained. Where the optimum is ill-conditioned (a first-order bound says that
rounding of H and g in double precision may move it by more than 1e-6) accelerations and wrenches
are reported but not checked; rows, cost and slope are checked as everywhere.

    python benchmarks/correctness.py --problems 5000
    python benchmarks/correctness.py --solver daqp --kind degenerate --keep out/faults
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import json
import pickle
import sys
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "tools"))
import certified_comparison
import random_cases
from certified_comparison import Comparison, ProblemClass
from random_cases import KINDS, Case

import wbc
from wbc.qp import Problem

DEFAULT = "default"
WORST = ("acceleration", "wrench", "torque", "violation", "excess", "slope")


@dataclass
class Tally:
    """The results of the ticks of one kind with one solver."""

    ticks: int = 0
    solvable: int = 0
    ill_conditioned: int = 0
    infeasible: int = 0
    recognised: int = 0  #: infeasible ones that were called so, and explained
    undecided: int = 0  #: nearly infeasible, or not certified
    faults: int = 0
    #: largest errors of the solvable ones, faults left out
    worst: dict[str, float] = field(default_factory=lambda: dict.fromkeys(WORST, 0.0))
    ill_off: float = 0.0  #: largest error of the ill-conditioned ones, faults left out

    def count(self, comparison: Comparison) -> None:
        """Count the comparison of one tick."""
        self.ticks += 1
        self.faults += bool(comparison.fault)
        problem_class = comparison.problem_class
        self.solvable += problem_class is ProblemClass.SOLVABLE
        self.ill_conditioned += problem_class is ProblemClass.ILL_CONDITIONED
        self.infeasible += problem_class is ProblemClass.INFEASIBLE
        self.recognised += problem_class is ProblemClass.INFEASIBLE and not comparison.fault
        self.undecided += problem_class in (ProblemClass.MARGINAL, ProblemClass.UNCERTIFIED)
        off = max(comparison.acceleration, comparison.wrench)
        if comparison.fault:
            return  # listed apart
        if problem_class is ProblemClass.ILL_CONDITIONED:
            self.ill_off = max(self.ill_off, off)
        elif problem_class is ProblemClass.SOLVABLE:
            for name in WORST:
                self.worst[name] = max(self.worst[name], getattr(comparison, name))

    def add(self, other: Tally) -> None:
        """Add the counts of another tally."""
        for name in ("ticks", "solvable", "ill_conditioned", "infeasible", "recognised"):
            setattr(self, name, getattr(self, name) + getattr(other, name))
        self.undecided += other.undecided
        self.faults += other.faults
        self.ill_off = max(self.ill_off, other.ill_off)
        self.worst = {name: max(self.worst[name], other.worst[name]) for name in WORST}


def store_fault(folder: Path, comparison: Comparison, problem: Problem | None) -> None:
    """Store a fault: case, tick, what is wrong, and the controller's QP."""
    folder.mkdir(parents=True, exist_ok=True)
    kind = comparison.case.kind.replace(" ", "_")
    path = folder / f"{kind}_{comparison.case.seed}_{comparison.tick}.pkl"
    path.write_bytes(pickle.dumps((comparison.case, comparison.tick, comparison.fault, problem)))


def table(title: str, tallies: dict[str, Tally]) -> str:
    """Return the table of one solver's results."""
    whole = Tally()
    for tally in tallies.values():
        whole.add(tally)
    lines = [title]
    head = ("", "ticks", "solvable", "ill-cond.", "infeasible", "reported", "open", "faults")
    errors = ("v̇ off", "f off", "row off", "cost off", "slope", "ill v̇, f off")
    lines.append(f"{head[0]:<24}" + "".join(f"{h:>11}" for h in head[1:]))
    lines[-1] += "".join(f"{e:>14}" for e in errors)
    for kind, t in {**tallies, "all": whole}.items():
        counts = (t.ticks, t.solvable, t.ill_conditioned, t.infeasible, t.recognised, t.undecided)
        text = f"{kind:<24}" + "".join(f"{c:>11}" for c in (*counts, t.faults))
        worst = [t.worst[name] for name in WORST if name != "torque"]
        lines.append(text + "".join(f"{w:>14.1e}" for w in (*worst, t.ill_off)))
    return "\n".join(lines)


def run(cases: list[Case], solvers: list[str], formulation: str | None, args: Any) -> Any:
    """Return the tallies by solver and kind, and the faults."""
    chosen = wbc.Formulation(formulation) if formulation else None
    tallies = {s: {kind: Tally() for kind in args.kind or KINDS} for s in solvers}
    faults: list[dict[str, Any]] = []
    for case in cases:
        for solver in solvers:
            name = None if solver == DEFAULT else solver
            for comparison, problem in certified_comparison.compare_ticks(case, name, chosen):
                tallies[solver][case.kind].count(comparison)
                if comparison.fault:
                    faults.append({"solver": solver, "problem": comparison.problem_class.value})
                    faults[-1] |= {"case": asdict(case), "tick": comparison.tick}
                    faults[-1]["fault"] = comparison.fault
                    if args.keep:
                        store_fault(args.keep / solver, comparison, problem)
        certified_comparison.references.cache_clear()
    return tallies, faults


def main() -> int:
    """Generate problems, solve and assess them, print the table and write the JSON file."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--problems", type=int, default=1000, help="ticks (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--solver", action="append", help="default: the default one and daqp")
    parser.add_argument("--kind", action="append", choices=KINDS, help="only these problems")
    formulations = [f.value for f in wbc.Formulation]
    parser.add_argument("--formulation", choices=formulations, help="the default one if left out")
    parser.add_argument("--keep", type=Path, help="pickle the QPs of faulty ticks into this folder")
    parser.add_argument("--json", type=Path, help="write the tables and the faults there")
    args = parser.parse_args()
    solvers = args.solver or [DEFAULT, "daqp"]
    begun = time.perf_counter()
    cases = list(random_cases.cases(args.problems, args.seed, args.kind or tuple(KINDS)))
    tallies, faults = run(cases, solvers, args.formulation, args)
    for solver in solvers:
        form = args.formulation or "default"
        print(table(f"solver {solver}, formulation {form}", tallies[solver]) + "\n")
    for fault in faults[:20]:
        case = random_cases.Case(**fault["case"])
        print(f"{fault['solver']}: {case}, tick {fault['tick']}: {fault['fault'][:160]}")
    if len(faults) > 20:
        print(f"… and {len(faults) - 20} more")
    print(f"\n{len(faults)} faults; {time.perf_counter() - begun:.0f} s")
    if args.json:
        result = {s: {k: asdict(t) for k, t in tallies[s].items()} for s in solvers}
        text = {"formulation": args.formulation or "default", "seed": args.seed, **result}
        args.json.write_text(json.dumps({**text, "faults": faults}, indent=2) + "\n")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
