"""Tuning: the parameter file, separate seeds, and a search on made-up results."""

from __future__ import annotations

import pytest
from trialtools import made_up

from wbc.trials import (
    ControllerSpec,
    Grid,
    ParameterRange,
    RobotCases,
    TrialError,
    TuningSpace,
    read_tuning_space,
    tune,
    tuning,
)

GRID = Grid((RobotCases("g1"),), (0.2, 0.4))
SPACE = TuningSpace((100,), (ParameterRange(("gains", "ankle_share"), 0.1, 0.9),))


@pytest.fixture
def evaluated(monkeypatch):
    """Replaces physics: the nearer the share is to 0.7, the larger the push that is survived."""
    pytest.importorskip("optuna")
    grids = []

    def run_grid(grid, output, workers, **_):
        grids.append(grid)
        share = grid.controllers[0].options.get("gains", {}).get("ankle_share", 0.1)
        return made_up(0.9 - abs(share - 0.7), 0.05, len(grids))

    monkeypatch.setattr(tuning, "run_grid", run_grid)
    return grids


def test_the_best_parameters_are_found_on_the_seeds_of_the_tuning(evaluated, tmp_path):
    result = tune(GRID, SPACE, 25, tmp_path, None)
    assert result.parameters["gains.ankle_share"] == pytest.approx(0.7, abs=0.15)
    assert result.controller.options == {"gains": result_gains(result)}
    assert result.survived > result.survived_before
    assert len(evaluated) == result.evaluations == 25
    assert {grid.seeds for grid in evaluated} == {(100,)}


def result_gains(result) -> dict[str, float]:
    return {name.removeprefix("gains."): value for name, value in result.parameters.items()}


def test_a_search_is_repeated_exactly(evaluated, tmp_path):
    tune(GRID, SPACE, 4, tmp_path, None)
    first = [grid.controllers for grid in evaluated]
    evaluated.clear()
    tune(GRID, SPACE, 6, tmp_path, None)
    assert [grid.controllers for grid in evaluated][:4] == first


def test_a_seed_of_the_grid_is_refused(tmp_path):
    pytest.importorskip("optuna")
    space = TuningSpace((3, 0), SPACE.ranges)
    with pytest.raises(TrialError, match="seed 0 is one of the grid's"):
        tune(GRID, space, 5, tmp_path, None)


def test_two_controllers_are_refused(tmp_path):
    pytest.importorskip("optuna")
    grid = Grid(GRID.robots, GRID.sizes, controllers=(ControllerSpec("a"), ControllerSpec("b")))
    with pytest.raises(TrialError, match="has 2 controllers"):
        tune(grid, SPACE, 5, tmp_path, None)


def test_a_parameter_file_is_read(tmp_path):
    path = tmp_path / "ranges.toml"
    path.write_text(
        "seeds = [100, 101]\n[gains.ankle_share]\nlow = 0.1\nhigh = 0.9\n"
        "[gait]\ndcm_gain = { low = 1, high = 10, log = true }\n"
    )
    space = read_tuning_space(path)
    assert space.seeds == (100, 101)
    assert space.ranges == (
        ParameterRange(("gains", "ankle_share"), 0.1, 0.9),
        ParameterRange(("gait", "dcm_gain"), 1.0, 10.0, True),
    )


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[gains.a]\nlow = 1\nhigh = 2", "seeds must be a list"),
        ("seeds = [1]", "at least one seed and one parameter"),
        ("seeds = [1]\n[gains.a]\nlow = 2\nhigh = 1", "gains.a: low = 2.0 must be below 1.0"),
        ("seeds = [1]\n[gains.a]\nlow = 1", "gains.a needs two numbers"),
        ("seeds = [1]\n[gains.a]\nlow = 1\nhigh = 2\nlgo = true", "unknown key 'gains.a.lgo'"),
        ("seeds = [1]\n[gains.a]\nlow = 0\nhigh = 2\nlog = true", "must be positive"),
        ("seeds = [1]\ngains = 3", "'gains' must be a table"),
        ("seeds = [", "no TOML"),
    ],
)
def test_a_bad_parameter_file_is_refused(tmp_path, text, words):
    path = tmp_path / "ranges.toml"
    path.write_text(text)
    with pytest.raises(TrialError, match=words):
        read_tuning_space(path)
