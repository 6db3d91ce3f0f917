"""`wbc trials tour`: waypoints, punches and arms that somebody else moves."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from concurrent.futures import as_completed
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

from wbc.cli.argument_types import (
    Argument,
    OutputFile,
    PolicyFolder,
    RobotName,
    positive_number,
    whole_number,
)
from wbc.cli.exit_code import ExitCode
from wbc.cli.formatting import table
from wbc.cli.output import OutputError
from wbc.cli.progress import ProgressLine
from wbc.trials.controllers import ControllerSpec
from wbc.trials.tour import (
    PUBLISHED,
    PublishedResult,
    TourParameters,
    TourResult,
    simulate_tour,
    summary,
)
from wbc.trials.workers import local_workers

_HEAD = ("controller", "runs", "completed, %", "survived, s", "off, cm", "off, °")


def tour(
    *,
    robot: RobotName = "g1_tour",
    seeds: Annotated[int, Argument("N", positive_number)] = 10,
    first_seed: Annotated[int, Argument("N", whole_number)] = 0,
    controller: str = "walker",
    policy: PolicyFolder | None = None,
    force: float = 500.0,
    workers: Annotated[int | None, Argument("N", positive_number)] = None,
    output: OutputFile | None = None,
) -> ExitCode:
    """Run the tour of the public teleop-walking-benchmark, and print how often it was completed.

    90 s, a waypoint every 5 s on a disc of 1 m radius, a punch on a random joint with each, and
    arms that somebody else moves. The table has the published policies too: share of the runs
    that ended on the feet, mean time until then or the fall, and mean distance and angle from a
    waypoint when its time is over.

    Args:
        robot: name of a robot, or path of a URDF or robot data file; g1_tour is G1 with the motors
            that the benchmark gives it.
        seeds: number of runs, each with a tour and sensor noise of its own.
        first_seed: seed of the first one; the others follow it.
        controller: "walker", or "module:factory" of a controller.
        policy: folder of a learned policy to run instead of a controller.
        force: largest force of a punch, N.
        workers: number of processes (default: one per core).
        output: write the runs to FILE, in JSON.
    """
    spec = ControllerSpec(controller, controller)
    if policy is not None:
        spec = ControllerSpec.of_policy(policy)
    spec.resolve()
    parameters = TourParameters(max_force=force)
    results: list[TourResult] = []
    with ProgressLine(period=10.0) as line, local_workers(workers) as pool:
        submit = pool.executor.submit
        drawn = range(first_seed, first_seed + seeds)
        runs = [submit(simulate_tour, robot, spec, seed, parameters) for seed in drawn]
        for run in as_completed(runs):
            result = run.result()
            results.append(result)
            line.print(_line(result))
    results.sort(key=lambda result: result.seed)
    print(_table(summary(spec.name, results), len(results)))
    if output is not None:
        _write(output, robot, spec, parameters, results)
    return ExitCode.SUCCESS


def _line(result: TourResult) -> str:
    if result.completed:
        return f"tour {result.seed}: completed"
    return (
        f"tour {result.seed}: fell after {result.survived:.1f} s, {result.fall}; the last punch "
        f"was {result.last_punch}"
    )


def _table(ours: PublishedResult, runs: int) -> str:
    rows = [_row(ours, str(runs))]
    rows += [_row(published, "published") for published in PUBLISHED]
    return table(_HEAD, rows, right=range(2, len(_HEAD)))


def _row(result: PublishedResult, runs: str) -> list[str]:
    return [
        result.name,
        runs,
        f"{100.0 * result.completed:.0f}",
        f"{result.survived:.1f}",
        f"{100.0 * result.position_error:.0f}",
        f"{math.degrees(result.yaw_error):.0f}",
    ]


def _write(
    path: Path,
    robot: str,
    spec: ControllerSpec,
    parameters: TourParameters,
    results: Sequence[TourResult],
) -> None:
    contents = {
        "robot": robot,
        "controller": spec.name,
        "parameters": asdict(parameters),
        "runs": [asdict(result) for result in results],
    }
    try:
        path.write_text(json.dumps(contents, indent=1) + "\n")
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror}") from error
