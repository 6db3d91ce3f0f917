"""Helpers for the tests of robots: edited copies of the test robot's URDF."""

from __future__ import annotations

from pathlib import Path

import wbc.robot

ROBOTS = Path(__file__).resolve().parents[2] / "robots"
SIMPLE = ROBOTS / "simple_humanoid.urdf"
CHAPTER = Path(__file__).parents[1] / "data" / "chapter_minimal.urdf"
FEET = {"left_foot": "left_foot", "right_foot": "right_foot"}


def changed(folder: Path, *replacements: tuple[str, str], name: str = "changed.urdf") -> Path:
    """Write a copy of the URDF with replacements, each of which must apply exactly once."""
    text = SIMPLE.read_text()
    for old, new in replacements:
        assert old in text, f"the URDF no longer holds {old!r}"
        text = text.replace(old, new, 1)
    path = folder / name
    path.write_text(text)
    return path


def element(kind: str, name: str) -> str:
    """Return the text of one `<link>` or `<joint>` of the URDF."""
    text = SIMPLE.read_text()
    start = text.index(f'  <{kind} name="{name}"')
    end = text.index(f"</{kind}>\n", start) + len(f"</{kind}>\n")
    return text[start:end]


def inertial(link: str) -> str:
    """The text of a link's `<inertial>`."""
    text = element("link", link)
    return text[text.index("<inertial>") : text.index("</inertial>") + len("</inertial>")]


def codes(findings: list[wbc.robot.Finding]) -> set[tuple[str, str]]:
    """(code, subject) of each finding."""
    return {(finding.code, finding.subject) for finding in findings}
