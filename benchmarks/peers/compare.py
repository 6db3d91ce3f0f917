"""`python benchmarks/tick.py --peers`: our tick against other libraries' on the same states."""

from __future__ import annotations

import argparse
import json
import platform
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from peers import environments, report
from peers.agreement import Agreement, active_rows, agreement
from peers.case import Case
from peers.figures import Figures, Ratio, figures, ratio
from peers.libraries import LIBRARIES, Library
from peers.process import LibraryFailedError, Worker
from peers.recording import CASES, record_cases


@dataclass
class Column:
    """One library on one case.

    Attributes:
        cpu: per round, (passes, ticks) ns.
        wall: likewise.
        solutions: what it found, see `Outcome`.
        failed: why there are no times.
    """

    cpu: list[np.ndarray] = field(default_factory=list)
    wall: list[np.ndarray] = field(default_factory=list)
    solutions: dict[str, np.ndarray] = field(default_factory=dict)
    failed: str = ""


@dataclass
class Comparison:
    """Everything that was measured.

    Attributes:
        cases: in order.
        libraries: those that ran, in order.
        missing: label -> why it did not.
        versions: library's key -> package -> version.
        columns: (case's name, library's key) -> what was measured.
    """

    cases: list[Case]
    libraries: list[Library]
    missing: dict[str, str]
    versions: dict[str, dict[str, str]] = field(default_factory=dict)
    columns: dict[tuple[str, str], Column] = field(default_factory=dict)

    def figures(self, case: str, key: str) -> Figures | None:
        """Return the CPU time of a library on a case; None if it did not run."""
        column = self.columns.get((case, key))
        return figures(np.concatenate(column.cpu)) if column and column.cpu else None

    def ratio(self, case: str, library: Library, versus: str | None = None) -> Ratio | None:
        """Return our times over the library's; `versus` names another configuration of ours."""
        ours = self.columns.get((case, versus or library.versus or ""))
        theirs = self.columns.get((case, library.key))
        if not ours or not theirs or not ours.cpu or len(ours.cpu) != len(theirs.cpu):
            return None
        return ratio(ours.cpu, theirs.cpu)

    def agreement(self, case: Case, library: Library) -> Agreement | None:
        """Return the differences of the library's solutions from ours."""
        ours = self.columns.get((case.name, library.versus or ""))
        theirs = self.columns.get((case.name, library.key))
        if not library.torques or not ours or not theirs:
            return None
        if not ours.solutions or not theirs.solutions:
            return None
        return agreement(case, ours.solutions, theirs.solutions)


def main(arguments: Sequence[str] | None = None) -> None:
    """Create the environments, record the cases, measure, print and write the results."""
    options = parser().parse_args(arguments)
    libraries, pythons, missing = available(options.libraries, options.env_dir)
    with tempfile.TemporaryDirectory(prefix="wbc-peers-") as scratch:
        folder = Path(scratch)
        print(f"recording {', '.join(options.case)} …", flush=True)
        cases = record_cases(options.case, options.ticks)
        for case in cases:
            case.save(folder / case.name)
        found = Comparison(cases, libraries, missing)
        run(found, pythons, folder, options.rounds, options.passes)
    report.show(found)
    if options.json:
        options.json.write_text(json.dumps(as_json(found, options), indent=2) + "\n")
    if options.plot:
        from peers.plot import draw

        draw(found, options.plot)


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    made = argparse.ArgumentParser(
        prog="tick.py --peers", description=(__doc__ or "").split(": ", 1)[1]
    )
    made.add_argument("--peers", action="store_true", help=argparse.SUPPRESS)
    made.add_argument(
        "--rounds",
        type=int,
        default=5,
        help="rounds in which the libraries take turns (default: %(default)s)",
    )
    made.add_argument(
        "--passes",
        type=int,
        default=5,
        help="passes over all ticks in each round (default: %(default)s)",
    )
    made.add_argument(
        "--ticks", type=int, default=500, help="most ticks of each case (default: %(default)s)"
    )
    made.add_argument("--case", nargs="+", choices=tuple(CASES), default=list(CASES))
    made.add_argument(
        "--libraries",
        nargs="+",
        choices=[library.key for library in LIBRARIES],
        default=[library.key for library in LIBRARIES],
    )
    made.add_argument(
        "--env-dir",
        type=Path,
        default=environments.default_folder(),
        help="where the peers' environments are kept (default: %(default)s)",
    )
    made.add_argument("--json", type=Path, help="write all figures to this file")
    made.add_argument("--plot", type=Path, help="plot medians and 99th percentiles to this file")
    return made


def available(
    keys: Sequence[str], folder: Path
) -> tuple[list[Library], dict[str, Path | None], dict[str, str]]:
    """Return the libraries whose environment can be used, and the reasons why others cannot."""
    libraries, missing = [], {}
    pythons: dict[str, Path | None] = {}
    refused: dict[str, str] = {}
    for library in LIBRARIES:
        if library.key not in keys:
            continue
        name = library.environment
        if name is not None and name not in pythons and name not in refused:
            try:
                pythons[name] = environments.prepare(name, folder)
            except environments.EnvironmentFailedError as error:
                refused[name] = str(error)
                print(f"{error}\n{name}: is skipped; the others run", flush=True)
        if name is None or name in pythons:
            libraries.append(library)
        else:
            missing[library.label] = refused[name]
    return libraries, pythons, missing


def run(
    found: Comparison, pythons: dict[str, Path | None], folder: Path, rounds: int, passes: int
) -> None:
    """Run rounds of fresh processes, which take turns case by case; only one of them computes."""

    def start(library: Library) -> Worker:
        scratch = folder / f"worker-{library.key}"
        scratch.mkdir(exist_ok=True)
        return Worker(library.adapter, pythons.get(library.environment or ""), scratch)

    for n in range(rounds):
        begun = time.perf_counter()
        workers = {library.key: start(library) for library in found.libraries}
        for case in found.cases:
            for library in found.libraries:
                column = found.columns.setdefault((case.name, library.key), Column())
                if column.failed:
                    continue
                worker = workers[library.key]
                try:
                    if n == 0:
                        column.solutions = worker.solve(folder / case.name)
                    times = worker.time(folder / case.name, passes)
                except LibraryFailedError as error:
                    column.failed = str(error)
                    column.cpu.clear()
                    print(f"{library.label} failed on {case.name}: {error}", flush=True)
                    worker.close()
                    workers[library.key] = start(library)
                    continue
                column.cpu.append(times["cpu"])
                column.wall.append(times["wall"])
                found.versions[library.key] = worker.versions
        for worker in workers.values():
            worker.close()
        print(f"round {n + 1} of {rounds}: {time.perf_counter() - begun:.0f} s", flush=True)


def as_json(found: Comparison, options: argparse.Namespace) -> dict[str, object]:
    """Return all figures as plain data."""
    cases: dict[str, object] = {}
    for case in found.cases:
        columns: dict[str, object] = {}
        for library in found.libraries:
            column = found.columns[case.name, library.key]
            cpu = found.figures(case.name, library.key)
            if cpu is None:
                columns[library.key] = {"failed": column.failed}
                continue
            entry: dict[str, object] = {
                "cpu_us": asdict(cpu),
                "wall_us": asdict(figures(np.concatenate(column.wall))),
                "rounds_cpu_us": [asdict(figures(times)) for times in column.cpu],
            }
            ratios = found.ratio(case.name, library)
            if ratios is not None:
                entry["ours_over_this"] = asdict(ratios)
                entry["ours_over_this"]["median_of_rounds"] = ratios.median_of_rounds
                entry["versus"] = library.versus
            if library.versus not in (None, "wbc"):
                whole = found.ratio(case.name, library, "wbc")
                entry["our_whole_problem_over_this"] = asdict(whole) if whole else None
            near = found.agreement(case, library)
            if near is not None:
                entry["agreement"] = asdict(near)
            columns[library.key] = entry
        ours = found.columns.get((case.name, "wbc"))
        rows = active_rows(case, ours.solutions) if ours and ours.solutions else np.zeros(0)
        cases[case.name] = {
            "title": case.title,
            "ticks": len(case.ticks),
            "active_rows_p50": float(np.median(rows)) if len(rows) else None,
            "active_rows_max": int(rows.max()) if len(rows) else None,
            "libraries": columns,
        }
    return {
        "machine": {
            "processor": report.processor(),
            "python": platform.python_version(),
            "programs_per_core": report.busy(),
        },
        "rounds": options.rounds,
        "passes": options.passes,
        "versions": found.versions,
        "missing": found.missing,
        "cases": cases,
    }
