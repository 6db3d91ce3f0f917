"""The README keeps its promises: its code runs, its robots and commands exist."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

import wbc
from wbc.cli import main
from wbc.robot import available

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "README.md").read_text("utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", TEXT, re.MULTILINE | re.DOTALL)


def test_the_python_blocks_run_one_after_the_other(tmp_path):
    code = "\n".join(blocks("python"))
    assert "wbc.run(" in code
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=180,
    )
    assert done.returncode == 0, done.stderr
    assert "survived" in done.stdout


@pytest.mark.parametrize("name", available())
def test_the_table_of_robots_equals_the_loaded_robots(name):
    robot = wbc.load(name)
    row = next(line for line in TEXT.splitlines() if line.startswith(f"| `{name}` "))
    cells = [cell.strip() for cell in row.strip("|").split("|")]
    left = robot.soles[0]
    assert cells[1] == str(robot.na)
    assert cells[2] == f"{robot.mass:.1f} kg"
    assert cells[3] == f"{2000 * left.half_length:.0f} × {2000 * left.half_width:.0f} mm"


def test_command_lines_of_the_readme_parse(capsys):
    lines = [line for block in blocks("sh") for line in block.replace("\\\n", "").splitlines()]
    commands = [shlex.split(line, comments=True)[1:] for line in lines if line.startswith("wbc ")]
    assert len(commands) >= 8
    for command in commands:
        # --help ends the command before it runs, but after all that precedes it was parsed.
        assert main([*command, "--help"]) == 0, command
    capsys.readouterr()


def test_linked_files_exist():
    for target in re.findall(r"\]\(([^)#]+)\)", TEXT):
        if "://" not in target:
            assert (ROOT / target).exists(), target
    for target in ("benchmarks/walk.py", "Makefile", ".ci/run"):
        assert (ROOT / target).exists()


def test_the_measured_table_can_be_inserted():
    assert TEXT.index("<!-- walk:begin -->") < TEXT.index("<!-- walk:end -->")
