"""The scoreboard: tables of pushes and tours from files of results."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import scoreboard

from wbc.trials.survival import Case, Survival, SurvivalRate


def survival(controller: str, direction: float, *survived: int) -> Survival:
    sizes = (0.2, 0.4, 0.6)
    rates = tuple(SurvivalRate(s, n, 20) for s, n in zip(sizes, survived, strict=True))
    return Survival(Case("g1", controller, (0.3, 0.0, 0.0), "nominal"), direction, rates)


def test_a_cell_is_the_largest_push_below_which_all_are_survived():
    found = [
        survival("walker", 0.0, 20, 19, 20),
        survival("walker", 90.0, 20, 18, 20),
        survival("policy", 0.0, 10, 20, 20),
    ]
    table = scoreboard.push_table(scoreboard.push_rows(found)).splitlines()
    assert table[0] == "| robot | motion | controller | forward | left | trials per size |"
    assert "| g1 | 0.3 m/s | walker | 0.60+ | 0.20 | 20 |" in table
    assert "| g1 | 0.3 m/s | policy | 0.00 |  | 20 |" in table


def test_tours_stand_among_the_published_ones_by_the_time_survived(tmp_path, capsys):
    run = {
        "seed": 0,
        "completed": False,
        "survived": 60.0,
        "position_error": 0.2,
        "yaw_error": 0.5,
        "fall": "tilted",
        "last_punch": "300 N",
    }
    better = run | {"completed": True, "survived": 90.0}
    path, out = tmp_path / "tour.json", tmp_path / "deep" / "scoreboard.json"
    path.write_text(json.dumps({"controller": "walker", "runs": [run, better]}))
    scoreboard.main(["--tour", str(path), "--json", str(out)])
    lines = capsys.readouterr().out.splitlines()
    position = lines.index("| **walker** | 2 | 50 | 75.0 | 20 | 29 |")
    assert "amo" in lines[position - 1]
    assert "grove" in lines[position + 1]
    assert json.loads(out.read_text())["tours"][4]["survived_s"] == 75.0


def test_a_file_that_is_no_tour_is_refused(tmp_path):
    path = tmp_path / "tour.json"
    path.write_text("{}")
    with pytest.raises(SystemExit, match=r"tour.json is no result of `wbc trials tour"):
        scoreboard.main(["--tour", str(path)])
