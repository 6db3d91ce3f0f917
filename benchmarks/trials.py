"""Measures how trials scale over the processes of this machine and over Dask workers.

The same grid runs on one, two … workers, which have loaded everything by a small grid before. An
efficiency is the throughput divided by that of one worker times their number. The share of the
parent process in the CPU time bounds what any number of workers can do together. All results are
compared bit by bit.

    python benchmarks/trials.py --json trials.json
    python benchmarks/trials.py --workers 1 2 4 8 --seeds 4
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import contextlib
import json
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from wbc.cli.formatting import table
from wbc.trials import Grid, RobotCases, Workers, dask_workers, local_workers, run_grid


@dataclass
class Measurement:
    """The throughput on some workers.

    Attributes:
        kind: "processes" or "Dask workers".
        workers: their number.
        wall_s: wall time of the grid, s.
        trials_per_s: throughput.
        efficiency: throughput over that of one worker of the kind times their number.
        parent_share: CPU time of this process over wall time times workers.
    """

    kind: str
    workers: int
    wall_s: float
    trials_per_s: float
    efficiency: float
    parent_share: float


@contextlib.contextmanager
def started(kind: str, count: int) -> Iterator[Workers]:
    """Start workers."""
    if kind == "processes":
        with local_workers(count) as workers:
            yield workers
        return
    from distributed import LocalCluster

    settings = {"threads_per_worker": 1, "dashboard_address": None, "silence_logs": 50}
    with (
        LocalCluster(n_workers=count, **settings) as cluster,
        dask_workers(cluster.scheduler_address) as workers,
    ):
        yield workers


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2], metavar="N")
    parser.add_argument("--robot", default="g1")
    parser.add_argument("--seeds", type=int, default=2, help="undisturbed runs")
    parser.add_argument("--kinds", nargs="+", default=["processes", "Dask workers"], metavar="KIND")
    parser.add_argument("--json", type=Path, metavar="FILE")
    options = parser.parse_args()
    grid = Grid(
        (RobotCases(options.robot, (0.2,)),),
        sizes=(0.1, 0.2),
        phases=2,
        seeds=tuple(range(options.seeds)),
    )
    warm_up = replace(grid, phases=1, sizes=(0.1,), seeds=tuple(range(100, 100 + options.seeds)))
    measurements: list[Measurement] = []
    contents = set()
    with TemporaryDirectory() as folder:
        for kind in options.kinds:
            single = 0.0
            for count in options.workers:
                output = Path(folder, f"{kind} {count}.parquet")
                with started(kind, count) as workers:
                    run_grid(warm_up, output.with_suffix(".warm"), workers)
                    begin, cpu = time.perf_counter(), time.process_time()
                    results = run_grid(grid, output, workers)
                    wall, parent = time.perf_counter() - begin, time.process_time() - cpu
                contents.add(output.read_bytes())
                rate = len(results.rows) / wall
                single = single or rate / count
                one = Measurement(kind, count, wall, rate, rate / (single * count), 0.0)
                measurements.append(replace(one, parent_share=parent / (wall * count)))
                print(f"{kind}, {count}: {wall:.1f} s", flush=True)
    rows = [
        [
            *(m.kind, f"{m.workers}", f"{m.wall_s:.1f}", f"{m.trials_per_s:.2f}"),
            *(f"{m.efficiency:.2f}", f"{m.parent_share:.1%}"),
        ]
        for m in measurements
    ]
    head = ["workers", "number", "time, s", "trials/s", "efficiency", "parent's CPU"]
    print(f"\n{table(head, rows, right=range(1, 6))}")
    print(f"\nresults bit-identical: {'yes' if len(contents) == 1 else 'NO'}")
    if options.json is not None:
        options.json.write_text(json.dumps([asdict(m) for m in measurements], indent=2))


if __name__ == "__main__":
    main()
