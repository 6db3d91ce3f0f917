"""Prints the comparison."""

from __future__ import annotations

import os
import platform
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from peers.agreement import active_rows
from peers.case import Case

if TYPE_CHECKING:
    from peers.compare import Comparison

WIDTH = 36
BUSY = 0.8  # programs per core; this comparison is one of them


def show(found: Comparison) -> None:
    """Print all tables; p99* is `Figures.p99_of_ticks`."""
    print(f"\n{processor()}; CPU time of one process, one thread; ratio = ours / theirs")
    if busy() > BUSY:
        print(
            f"The machine is busy ({busy():.1f} programs per core): p99 and max are mostly its "
            "own; p50 and p99* bear it."
        )
    for case in found.cases:
        _show_case(found, case)
    _show_agreement(found)
    print("\nversions")
    for library in found.libraries:
        packages = found.versions.get(library.key, {})
        print(f"  {library.label:<{WIDTH}}" + ", ".join(f"{k} {v}" for k, v in packages.items()))
    for label, why in found.missing.items():
        print(f"  {label:<{WIDTH}}missing: {why.splitlines()[0]}")


def _show_case(found: Comparison, case: Case) -> None:
    ours = found.columns.get((case.name, "wbc"))
    rows = active_rows(case, ours.solutions) if ours and ours.solutions else None
    active = "" if rows is None else f"; active limits {np.median(rows):.0f} ({rows.max():.0f})"
    print(f"\n{case.title}: {len(case.ticks)} ticks{active}")
    head = f"{'µs':<{WIDTH}}{'p50':>7}{'p99':>8}{'max':>8}{'p99*':>8}"
    print(head + "   ratio: p50    p99   p99*   rounds")
    for library in found.libraries:
        cpu = found.figures(case.name, library.key)
        if cpu is None:
            print(f"{library.label:<{WIDTH}}failed")
            continue
        line = f"{library.label:<{WIDTH}}{cpu.p50:>7.0f}{cpu.p99:>8.0f}{cpu.max:>8.0f}"
        line += f"{cpu.p99_of_ticks:>8.0f}"
        ratios = found.ratio(case.name, library)
        if ratios is not None:
            line += f"{ratios.p50:>13.2f}{ratios.p99:>7.2f}{ratios.p99_of_ticks:>7.2f}   "
            line += " ".join(f"{r:.2f}" for r in ratios.rounds)
        print(line)


def _show_agreement(found: Comparison) -> None:
    peers = [one for one in found.libraries if one.versus and one.torques]
    if not peers:
        return
    print("\nThe same problem? Their answer less ours: largest entry, median of ticks (worst tick)")
    columns = ("CoM m/s²", "v̇ m/s², rad/s²", "torque N·m", "wrench N, N·m")
    print(f"{'':<{WIDTH}}" + "".join(f"{name:>20}" for name in columns) + "  unsolved")
    for library in peers:
        for case in found.cases:
            near = found.agreement(case, library)
            if near is None:
                continue
            spreads = (near.com, near.acceleration, near.torque, near.wrench)
            line = f"{library.key + ', ' + case.title:<{WIDTH}}"
            line += "".join(f"{s.median:>10.0e} ({s.max:.0e})" for s in spreads)
            print(line + f"{near.unsolved:>10}")
        why = textwrap.fill(library.differs, 96, initial_indent="  ", subsequent_indent="  ")
        print(why)


def busy() -> float:
    """Return the runnable programs per core over the last minute; NaN if unknown."""
    try:
        return os.getloadavg()[0] / (os.cpu_count() or 1)
    except OSError:
        return float("nan")


def processor() -> str:
    """Return the name of the processor."""
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
