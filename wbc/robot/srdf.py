"""Named postures and disabled collisions from a semantic description (SRDF).

The keyframes of an MJCF file are postures of the same form, see `wbc.robot.mjcf`.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from wbc.errors import RobotDescriptionError, did_you_mean
from wbc.robot.urdf import read_xml

# Common names of a posture to stand in, in order of preference.
STANDING_NAMES = ("half_sitting", "standing", "stand", "half_sit", "default", "home", "initial")


@dataclass(frozen=True, slots=True)
class GroupState:
    """A named posture: joint name to position (rad or m), from the file `source`."""

    name: str
    joints: dict[str, float]
    source: str


def find_srdf(urdf: Path) -> Path | None:
    """Return the SRDF that belongs to a URDF by the usual layout of packages, or None.

    `<package>/urdf/talos_reduced.urdf` goes with `<package>/srdf/talos.srdf`:
    the longest SRDF name that begins the URDF's, or else the only SRDF there.
    """
    found: list[Path] = []
    for folder in (urdf.parent, urdf.parent / "srdf", urdf.parent.parent / "srdf"):
        found += sorted(folder.glob("*.srdf"))
    fitting = [path for path in found if urdf.stem.startswith(path.stem)]
    if fitting:
        return max(fitting, key=lambda path: len(path.stem))
    return found[0] if len(found) == 1 else None


def read_group_state(srdf: Path, wanted: str | None = None) -> GroupState | None:
    """Return the wanted posture of an SRDF, by default the one to stand in; None without one.

    Raises:
        RobotDescriptionError: unreadable, malformed, no such posture, or a
            joint value that is no number.
    """
    return group_state(srdf, *read_xml(srdf), wanted)


def group_state(
    path: Path, root: ET.Element, lines: Mapping[ET.Element, int], wanted: str | None
) -> GroupState | None:
    """Return the wanted posture among the children of an element; see `read_group_state`.

    Args:
        path: the file, for messages.
        root: the element.
        lines: line of each element in the file; empty if it was generated.
        wanted: its name; None for the one to stand in.
    """
    states = {state.get("name", ""): state for state in root.findall("group_state")}
    if wanted is not None and wanted not in states:
        raise RobotDescriptionError(
            f"{path}: there is no group_state '{wanted}'{did_you_mean(wanted, states)}"
        )
    name = wanted or next((n for n in STANDING_NAMES if n in states), None)
    if name is None:
        return None
    joints = {}
    for element in states[name].findall("joint"):
        words = element.get("value", "").split()
        # The root joint's seven numbers place the robot in a world; standing does that anew.
        if len(words) == 1:
            try:
                joints[element.get("name", "")] = float(words[0])
            except ValueError as error:
                raise RobotDescriptionError(
                    f"{path}, line {lines.get(element, 0)}: joint '{element.get('name')}' "
                    f"has the value '{words[0]}', which is no number"
                ) from error
    return GroupState(name, joints, path.name)


def read_disabled_collisions(srdf: Path) -> set[frozenset[str]]:
    """Return the pairs of links whose collisions an SRDF disables.

    Raises:
        RobotDescriptionError: unreadable or malformed.
    """
    root, _ = read_xml(srdf)
    return {
        frozenset((element.get("link1", ""), element.get("link2", "")))
        for element in root.findall("disable_collisions")
    }
