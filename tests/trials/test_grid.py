"""Grids of trials: from TOML and back, errors, keys."""

from __future__ import annotations

import copy
import json
import pickle
from dataclasses import replace
from pathlib import Path

import pytest

from wbc.trials import (
    Condition,
    ControllerSpec,
    Grid,
    KickDisturbance,
    PushDisturbance,
    RobotCases,
    TrialError,
    read_grid,
    write_grid,
)
from wbc.trials.grid_file import grid_to_json, parse_grid

GRIDS = Path(__file__).resolve().parents[2] / "benchmarks" / "grids"
SMALL = {"robots": [{"robot": "g1"}], "sizes": [0.3]}


def grid(**changes) -> Grid:
    return Grid(**{"robots": (RobotCases("g1", (0.0, 0.2)),), "sizes": (0.3, 0.5), **changes})


def test_a_grid_has_a_trial_for_each_combination():
    declared = grid(
        phases=3,
        seeds=(0, 1),
        conditions=(Condition(), Condition("heavy", mass=1.1)),
        controllers=(ControllerSpec(), ControllerSpec("quick", options={"recovery": False})),
    )
    runs = list(declared.runs())
    assert len(runs) == 2 * 2 * 2 * 2  # velocities, conditions, controllers, seeds
    trials = list(declared.trials(runs[0]))
    assert len(trials) == 3 * 4 * 2  # phases, directions, sizes
    keys = {trial.key for run in runs for trial in declared.trials(run)} | {r.key for r in runs}
    assert len(keys) == 16 * 25


def test_a_robot_may_have_sizes_of_its_own():
    declared = grid(robots=(RobotCases("g1", sizes=(0.9,)), RobotCases("talos")))
    sizes = [{trial.size for trial in declared.trials(run)} for run in declared.runs()]
    assert sizes == [{0.9}, {0.3, 0.5}]


def test_each_velocity_and_direction_of_a_robot_may_have_sizes_of_its_own():
    standing = RobotCases("g1", sizes={"left": (0.7,), "back": (0.8, 0.9)})
    declared = grid(robots=(standing, RobotCases("g1", (0.3,))), phases=1)
    tried = [{(t.direction, t.size) for t in declared.trials(run)} for run in declared.runs()]
    assert tried[0] == {(90.0, 0.7), (180.0, 0.8), (180.0, 0.9)}
    assert tried[1] == {(d, size) for d in (0.0, 90.0, 180.0, 270.0) for size in (0.3, 0.5)}


def test_a_key_depends_on_all_that_decides_the_result_and_on_no_name():
    def keys(declared: Grid) -> set[str]:
        return {trial.key for run in declared.runs() for trial in declared.trials(run)}

    before = grid()
    assert keys(replace(before, name="other")) == keys(before)
    assert keys(replace(before, controllers=(ControllerSpec("other"),))) == keys(before)
    assert keys(replace(before, sizes=(1,))) == keys(replace(before, sizes=(1.0,)))
    assert keys(replace(before, phases=12)) > keys(before), "a finer grid repeats no trial"
    for change in (
        {"duration": 5.0},
        {"disturbance": PushDisturbance(duration=0.2)},
        {"disturbance": KickDisturbance()},
        {"conditions": (Condition(mass=1.1),)},
        {"controllers": (ControllerSpec(options={"recovery": False}),)},
    ):
        assert not keys(replace(before, **change)) & keys(before), change


def test_a_key_is_the_same_on_every_machine():
    run = next(grid().runs())
    assert run.key == "b66cb1ab1f692a304dcdf042"


@pytest.mark.parametrize("path", sorted(GRIDS.glob("*.toml")), ids=lambda path: path.stem)
def test_shipped_grids_can_be_read(path):
    assert list(read_grid(path).runs())


@pytest.mark.parametrize(
    "declared",
    [
        grid(),
        grid(disturbance=KickDisturbance(), phases=2, directions=("left", 45.0), seeds=(3, 4)),
        grid(disturbance=PushDisturbance(duration=0.2, frame="torso_link")),
        grid(robots=(RobotCases("g1", sizes={"left": (0.2,)}), RobotCases("g1", (0.2,)))),
        grid(
            controllers=(ControllerSpec("a", "my.module:make", {"path": "x", "gain": 2.0}),),
            conditions=(Condition("c", com_offset=(0.02, 0.0, 0.0), payload_on="hands"),),
        ),
    ],
)
def test_a_grid_is_read_back_as_it_was_written(declared, tmp_path):
    write_grid(declared, tmp_path / "grid.toml")
    assert read_grid(tmp_path / "grid.toml") == declared
    assert parse_grid(json.loads(grid_to_json(declared))) == declared
    assert pickle.loads(pickle.dumps(declared)) == copy.deepcopy(declared) == declared


def test_a_robot_is_run_with_the_controllers_that_it_names():
    controllers = tuple(map(ControllerSpec, ("walker", "other")))
    robots = RobotCases("g1"), RobotCases("talos", controllers=("other",))
    grid = Grid(robots, (0.3,), controllers=controllers)
    runs = [(run.robot, run.controller.name) for run in grid.runs()]
    assert runs == [("g1", "walker"), ("g1", "other"), ("talos", "other")]
    assert parse_grid(json.loads(grid_to_json(grid))) == grid


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"size": [1.0]}, r"unknown key 'size'; did you mean 'sizes'"),
        ({"sizes": ["a"]}, r"sizes\[0\]: .*not 'a'"),
        ({"sizes": [0.3, 0.3]}, "more than once"),
        ({"sizes": [-0.3]}, "positive"),
        ({"sizes": []}, "sizes is empty"),
        ({"phases": 0}, "phases = 0"),
        ({"phases": 2.5}, "phases: .*integer"),
        ({"directions": ["up"]}, "direction 'up' must be one of forward"),
        ({"directions": ["left", 90]}, "more than once"),
        ({"robots": [{"robot": "g1", "velocity": [0.1]}]}, r"robots\[0\].velocity'; did you mean"),
        ({"robots": [{"velocities": [0.1]}]}, r"'robots\[0\].robot' is missing"),
        ({"robots": [{"robot": "g1", "velocities": [[0.1, 0.2]]}]}, "three of forward, left"),
        ({"robots": [{"robot": "g1"}, {"robot": "g1"}]}, "'g1 at .* more than once"),
        ({"robots": [{"robot": "g1", "sizes": {"up": [0.3]}}]}, "direction 'up' must be one of"),
        ({"robots": [{"robot": "g1", "controllers": ["wlker"]}]}, "'wlker'; did you mean 'walker'"),
        ({"robots": [{"robot": "g1", "controllers": []}]}, "'g1' has no controllers"),
        ({"conditions": [{"latncy": 0.1}]}, r"conditions\[0\].latncy'; did you mean 'latency'"),
        ({"conditions": [{"name": "x", "mass": 0.0}]}, "'x': mass = 0.0 must be positive"),
        ({"conditions": [{}, {}]}, "'nominal' more than once"),
        ({"disturbance": {"kind": "pusch"}}, "one of push, force, kick, not 'pusch'"),
        ({"disturbance": {"kind": "kick", "duration": 1.0}}, "unknown key 'disturbance.duration'"),
        ({"disturbance": {"kind": "push", "duration": 0.0}}, "must be positive"),
        ({"seeds": [-1]}, "at least 0"),
    ],
)
def test_a_bad_grid_is_refused_with_the_place_of_the_error(change, words):
    with pytest.raises(TrialError, match=words):
        parse_grid({**SMALL, **change})


def test_a_file_that_is_no_grid_is_refused(tmp_path):
    with pytest.raises(TrialError, match="cannot read"):
        read_grid(tmp_path / "none.toml")
    (tmp_path / "bad.toml").write_text("a = [")
    with pytest.raises(TrialError, match="no TOML"):
        read_grid(tmp_path / "bad.toml")
