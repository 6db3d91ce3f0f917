"""Prints the push table of all controllers and the table of the tours, from files of results.

A cell is the largest push, N·s per kg of the robot's mass, that is survived in at least 95 % of the
trials, as are all smaller ones; + where it is the largest that was tried.

    wbc trials benchmarks/grids/peers.toml --policy DIR      # writes peers.parquet
    wbc trials tour --output walker.json
    python benchmarks/scoreboard.py peers.parquet --tour walker.json
    python benchmarks/scoreboard.py *.parquet --json out/scoreboard.json
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from wbc.trials.disturbance import direction_name
from wbc.trials.results import read_results
from wbc.trials.survival import Case, Survival, survival_rates
from wbc.trials.tour import PUBLISHED, PublishedResult, TourResult, summary


@dataclass(frozen=True)
class Row:
    """One line of the push table.

    Attributes:
        case: robot, controller, velocity and condition.
        trials: number of trials of each direction and size.
        cells: direction -> largest size that was survived, and whether a larger one was tried.
    """

    case: Case
    trials: int
    cells: dict[str, tuple[float, bool]]


def push_rows(survivals: Iterable[Survival]) -> list[Row]:
    """Return a row per case, by robot and velocity, then by controller."""
    by_case: dict[Case, list[Survival]] = {}
    for one in survivals:
        by_case.setdefault(one.case, []).append(one)
    rows = [
        Row(
            case,
            min(rate.trials for one in found for rate in one.rates),
            {direction_name(one.direction): _cell(one) for one in found},
        )
        for case, found in by_case.items()
    ]
    return sorted(rows, key=lambda row: (row.case.robot, row.case.velocity, row.case.condition))


def _cell(survival: Survival) -> tuple[float, bool]:
    largest = survival.largest_survived()
    return largest, largest < survival.rates[-1].size


def push_table(rows: Sequence[Row]) -> str:
    """Return the push table in Markdown."""
    directions = list(dict.fromkeys(name for row in rows for name in row.cells))
    conditions = len({row.case.condition for row in rows}) > 1
    head = ["robot", "motion", "controller", *(["condition"] if conditions else []), *directions]
    lines = [[*head, "trials per size"]]
    for row in rows:
        case = row.case
        labels = [case.robot, case.motion, case.controller]
        labels += [case.condition] if conditions else []
        cells = [_text(row.cells.get(direction)) for direction in directions]
        lines.append([*labels, *cells, str(row.trials)])
    return _markdown(lines, len(head) - len(directions))


def _text(cell: tuple[float, bool] | None) -> str:
    return "" if cell is None else f"{cell[0]:.2f}{'' if cell[1] else '+'}"


def tour_rows(paths: Iterable[Path]) -> list[tuple[PublishedResult, str]]:
    """Return the results of tours and the published ones, with their numbers of runs, best first.

    Raises:
        SystemExit: a file is no result of a tour.
    """
    rows = []
    for path in paths:
        try:
            contents = json.loads(path.read_text())
            runs = [TourResult(**run) for run in contents["runs"]]
            rows.append((summary(contents["controller"], runs), str(len(runs))))
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise SystemExit(
                f"{path} is no result of `wbc trials tour --output`: {error!r}"
            ) from None
    rows += [(result, "published") for result in PUBLISHED]
    return sorted(rows, key=lambda row: -row[0].survived)


def tour_table(rows: Sequence[tuple[PublishedResult, str]]) -> str:
    """Return the table of the tours in Markdown."""
    lines = [["controller", "runs", "completed, %", "survived, s", "off, cm", "off, °"]]
    lines += [
        [
            result.name if runs == "published" else f"**{result.name}**",
            runs,
            f"{100.0 * result.completed:.0f}",
            f"{result.survived:.1f}",
            f"{100.0 * result.position_error:.0f}",
            f"{math.degrees(result.yaw_error):.0f}",
        ]
        for result, runs in rows
    ]
    return _markdown(lines, 2)


def _markdown(lines: Sequence[Sequence[str]], labels: int) -> str:
    head, *body = (f"| {' | '.join(line)} |" for line in lines)
    columns = len(lines[0])
    rule = f"| {' | '.join(['---'] * labels + ['---:'] * (columns - labels))} |"
    return "\n".join([head, rule, *body])


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("results", type=Path, nargs="*", help="results of `wbc trials`, Parquet")
    parser.add_argument(
        "--tour", type=Path, nargs="+", default=[], help="results of `wbc trials tour --output`"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the tables to FILE")
    options = parser.parse_args(arguments)
    if not options.results and not options.tour:
        parser.error("give results of `wbc trials` or, after --tour, of `wbc trials tour`")
    trials = [row for path in options.results for row in read_results(path).trials]
    pushes, tours = push_rows(survival_rates(trials)), tour_rows(options.tour)
    parts = [push_table(pushes)] if pushes else []
    parts += [tour_table(tours)] if options.tour else []
    print("\n\n".join(parts))
    if options.json is not None:
        options.json.parent.mkdir(parents=True, exist_ok=True)
        options.json.write_text(json.dumps(_plain(pushes, tours), indent=1) + "\n")


def _plain(
    pushes: Sequence[Row], tours: Sequence[tuple[PublishedResult, str]]
) -> dict[str, object]:
    return {
        "pushes": [
            {
                "robot": row.case.robot,
                "motion": row.case.motion,
                "controller": row.case.controller,
                "condition": row.case.condition,
                "trials_per_size": row.trials,
                "largest_survived": {name: size for name, (size, _) in row.cells.items()},
            }
            for row in pushes
        ],
        "tours": [
            {
                "controller": result.name,
                "runs": runs,
                "completed": result.completed,
                "survived_s": result.survived,
                "position_error_m": result.position_error,
                "yaw_error_rad": result.yaw_error,
            }
            for result, runs in tours
        ],
    }


if __name__ == "__main__":
    main()
