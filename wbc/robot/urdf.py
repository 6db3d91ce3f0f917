"""A URDF file as XML elements with their line numbers.

Pinocchio's own reader reports a broken file on the C++ standard error, without a line number.
Reading the XML first lets every error name the line, and lets the loader give Pinocchio a
document that it accepts.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from wbc.errors import RobotDescriptionError


@dataclass(frozen=True, slots=True)
class UrdfJoint:
    """A `<joint>` of the file: its name, type, parent and child link, and its element."""

    name: str
    type: str
    parent: str
    child: str
    element: ET.Element


@dataclass(eq=False)
class Urdf:
    """The parsed file.

    Attributes:
        path: path of the file.
        element: the `<robot>` element.
        links: the first `<link>` element of each name, in file order.
        joints: the joints, in file order, duplicates included.
    """

    path: Path
    element: ET.Element
    links: dict[str, ET.Element]
    joints: list[UrdfJoint]
    _lines: dict[ET.Element, int] = field(repr=False, default_factory=dict)

    def line(self, element: ET.Element) -> int:
        """Return the line of the file on which the element opens; 0 if unknown."""
        return self._lines.get(element, 0)

    def where(self, element: ET.Element) -> str:
        """`file.urdf:12`, for messages."""
        return f"{self.path.name}:{self.line(element)}"

    def numbers(
        self, element: ET.Element | None, attribute: str, default: tuple[float, ...]
    ) -> list[float]:
        """Return the numbers of an attribute such as `xyz="0 0 1"`; the default if it is absent.

        Raises:
            RobotDescriptionError: it holds something else; the text names the line.
        """
        try:
            return floats(element, attribute, default)
        except ValueError as error:
            assert element is not None
            raise RobotDescriptionError(
                f"{self.path}, line {self.line(element)}: <{element.tag}> has {error}; "
                f"it must hold {len(default)} finite numbers"
            ) from error

    def roots(self) -> list[str]:
        """Return the links that are no joint's child, in file order."""
        children = {joint.child for joint in self.joints}
        return [name for name in self.links if name not in children]

    def descendants(self, root: str) -> set[str]:
        """Return the links that can be reached from a link, itself included."""
        children: dict[str, list[str]] = {}
        for joint in self.joints:
            children.setdefault(joint.parent, []).append(joint.child)
        found: set[str] = set()
        todo = [root]
        while todo:
            link = todo.pop()
            if link not in found:
                found.add(link)
                todo += children.get(link, [])
        return found

    def duplicates(self) -> list[tuple[str, str, int]]:
        """Return (`link` or `joint`, name, line) of every element whose name is taken already."""
        found = []
        for tag in ("link", "joint"):
            seen: set[str] = set()
            for element in self.element.findall(tag):
                name = element.get("name", "")
                if name in seen:
                    found.append((tag, name, self.line(element)))
                seen.add(name)
        return found


def read_xml(path: Path) -> tuple[ET.Element, dict[ET.Element, int]]:
    """Return the root element of an XML file and the line of each element.

    Raises:
        RobotDescriptionError: the file cannot be read or is not well-formed;
            the text names the line.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise RobotDescriptionError(
            f"cannot read {path}: {error.strerror or error}; give the path of a readable file"
        ) from error
    builder = ET.TreeBuilder()
    lines: dict[ET.Element, int] = {}
    parser = expat.ParserCreate()
    parser.buffer_text = True

    def start(tag: str, attributes: dict[str, str]) -> None:
        lines[builder.start(tag, attributes)] = parser.CurrentLineNumber

    parser.StartElementHandler = start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.data
    try:
        parser.Parse(content, True)
    except (expat.ExpatError, ValueError, LookupError) as error:
        line = getattr(error, "lineno", parser.CurrentLineNumber)
        reason = expat.ErrorString(error.code) if isinstance(error, expat.ExpatError) else error
        raise RobotDescriptionError(
            f"{path}, line {line}: the XML is malformed ({reason}); "
            "correct that line (a tag left open, a stray character, a missing quote)"
        ) from error
    return builder.close(), lines


def parse_urdf(path: Path, root: ET.Element, lines: dict[ET.Element, int]) -> Urdf:
    """Return the description that a URDF document holds.

    Args:
        path: file that it comes from.
        root: the document.
        lines: line of each element in the file; empty if it was generated.

    Raises:
        RobotDescriptionError: no URDF, a joint or link without a name, or a joint without its two
            links.
    """
    if root.tag != "robot":
        raise RobotDescriptionError(
            f"{path}, line {lines.get(root, 0)}: the root element is <{root.tag}>, a URDF begins "
            "with <robot>, an MJCF file with <mujoco>; give the path of one of them (convert SDF "
            "first)"
        )
    links: dict[str, ET.Element] = {}
    for element in root.findall("link"):
        links.setdefault(_name_of(element, path, lines), element)
    if not links:
        raise RobotDescriptionError(f"{path}: the file has no <link>; it describes no robot")
    joints = [_joint(element, path, lines) for element in root.findall("joint")]
    return Urdf(path, root, links, joints, lines)


def _name_of(element: ET.Element, path: Path, lines: dict[ET.Element, int]) -> str:
    name = element.get("name", "").strip()
    if not name:
        raise RobotDescriptionError(
            f"{path}, line {lines.get(element, 0)}: a <{element.tag}> has no name; give it one"
        )
    return name


def _joint(element: ET.Element, path: Path, lines: dict[ET.Element, int]) -> UrdfJoint:
    name = _name_of(element, path, lines)
    ends = {}
    for tag in ("parent", "child"):
        end = element.find(tag)
        link = end.get("link", "") if end is not None else ""
        if not link:
            raise RobotDescriptionError(
                f"{path}, line {lines.get(element, 0)}: joint '{name}' has no <{tag} link=…>; "
                "a joint needs both links"
            )
        ends[tag] = link
    return UrdfJoint(name, element.get("type", ""), ends["parent"], ends["child"], element)


def floats(element: ET.Element | None, attribute: str, default: tuple[float, ...]) -> list[float]:
    """Return the numbers of an attribute such as `xyz="0 0 1"`; the default if it is absent.

    Raises:
        ValueError: the attribute holds something else, another count of numbers,
            or one that is not finite.
    """
    text = element.get(attribute) if element is not None else None
    if text is None:
        return list(default)
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    if len(values) != len(default) or not all(math.isfinite(value) for value in values):
        raise ValueError(f'{attribute}="{text}"')
    return values
