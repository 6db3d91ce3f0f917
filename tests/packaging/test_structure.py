"""The structure of the library: names that are unique, and a picture that shows today's imports."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_no_two_classes_share_a_name():
    places = defaultdict(list)
    for path in sorted((ROOT / "wbc").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.ClassDef):
                places[node.name].append(str(path.relative_to(ROOT)))
    assert {name: files for name, files in places.items() if len(files) > 1} == {}


def test_picture_of_the_rooms_shows_the_present_imports():
    script = ROOT / "docs" / "draw_rooms.py"
    done = subprocess.run([sys.executable, script, "--check"], cwd=ROOT)
    assert done.returncode == 0, "run  python docs/draw_rooms.py"
