"""Gains and gait parameters from a file."""

import numpy as np
import pytest

import wbc
from wbc.teleop import CommandRefused
from wbc.teleop.gains_file import apply_gains


@pytest.fixture(scope="module")
def walker():
    return wbc.Walker(wbc.load("simple_humanoid"))


def test_a_file_sets_gains_and_gait_parameters(walker, tmp_path):
    path = tmp_path / "gains.toml"
    height = 1.2 * walker.gait.swing_height
    path.write_text(f'# tuned\n"gait.swing_height" = {height}  # m\n"com.weight" = 2500\n')
    apply_gains(walker, path)
    assert walker.gait.swing_height == height
    com = next(task for task in walker.tasks if task.name == "com")
    assert np.max(com.weight) == 2500.0


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('"com.wieght" = 1.0', "did you mean 'com.weight'"),
        ('"com.weight" = -1.0', "com.weight = -1.0 is out of range"),
        ('"com.weight" = "much"', "is 'much'; it is a number"),
        ("[com]\nweight = 1.0", "no parameter 'com'"),
        ("com weight", "is not a file of gains"),
    ],
)
def test_a_wrong_file_changes_nothing_and_says_why(walker, tmp_path, text, reason):
    path = tmp_path / "gains.toml"
    path.write_text(f'"gait.step_width" = {walker.gait.step_width}\n{text}\n')
    before = walker.gait
    with pytest.raises(CommandRefused, match=reason):
        apply_gains(walker, path)
    assert walker.gait is before
