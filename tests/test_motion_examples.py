"""The motions' examples: short, numbered, and each does what it says."""

from __future__ import annotations

import ast
import runpy
from pathlib import Path

import pytest

import wbc
from wbc.motions import CATALOGUE

FOLDER = Path(__file__).resolve().parents[1] / "examples" / "motions"
EXAMPLES = sorted(FOLDER.glob("*.py"))
SHOWN_ELSEWHERE = {"Jump"}  # has an example among those of the whole library

#: What each says; those that are left out are played by other tests, with the same parameters.
SAYS = {
    "02_squat": "21.0 % is the most",
    "07_bow": "survived",
    "10_keyframes": "robot_dance.csv:3:11: g1 has no joint 'torso_yaw'",
    "11_interrupt": "it stands as before: True",
    "12_own_motion": "2 kicks",
}


@pytest.mark.parametrize("name", SAYS)
def test_example_does_what_it_says(name, capsys):
    runpy.run_path(str(FOLDER / f"{name}.py"), run_name="__main__")
    said = capsys.readouterr().out
    assert SAYS[name] in said
    assert "FELL" not in said


@pytest.mark.parametrize("script", EXAMPLES, ids=lambda path: path.stem)
def test_example_is_short_and_uses_what_there_is(script):
    text = script.read_text("utf-8")
    assert text.startswith('"""')
    assert len(text.splitlines()) <= 60
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and node.module == "wbc.motions":
            for alias in node.names:
                assert hasattr(wbc.motions, alias.name), alias.name


def test_every_motion_has_an_example():
    text = "".join(script.read_text("utf-8") for script in EXAMPLES)
    for motion in CATALOGUE:
        assert motion.__name__ in SHOWN_ELSEWHERE or f"{motion.__name__}(" in text


def test_examples_are_numbered_without_gaps():
    assert [path.name[:3] for path in EXAMPLES] == [f"{k:02}_" for k in range(1, len(EXAMPLES) + 1)]
