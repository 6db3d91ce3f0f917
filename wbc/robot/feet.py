"""The feet: guessed from the names of the links, or stated and checked."""

from __future__ import annotations

import re

from wbc.errors import RobotDescriptionError, did_you_mean
from wbc.robot.urdf import Urdf

# In order of preference: a sole link, a foot link, the last link of the ankle.
PARTS = ("sole", "foot", "ankle roll", "ankle")
_SIDES = (
    ("left", "right"), ("l", "r"),
    ("fl", "fr"), ("hl", "hr"), ("rl", "rr"), ("lf", "rf"), ("lh", "rh"),
)  # fmt: skip
_PARTS_OF_NAMES = re.compile(
    r"[Ll]eft|[Rr]ight|[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+|\d+|[^A-Za-z\d]+"
)


def find_feet(urdf: Urdf) -> tuple[str, str] | None:
    """Return the (left, right) links whose names are those of feet, or None.

    A pair counts only if it is the only pair for its part of the body: a guess
    between the four feet of a quadruped would be arbitrary. An ankle is not taken
    for a foot if only one of the feet is named.
    """
    for part in PARTS:
        pairs, single = _feet(urdf, part)
        if pairs and (len(pairs) == 1 or len(pairs[0][0]) < len(pairs[1][0])):
            return pairs[0]
        if pairs or single:
            return None
    return None


def foot_pairs(urdf: Urdf) -> list[tuple[str, str]]:
    """Return all (left, right) pairs of links with the names of feet, those of the best part."""
    return next((pairs for part in PARTS if (pairs := _feet(urdf, part)[0])), [])


def _feet(urdf: Urdf, part: str) -> tuple[list[tuple[str, str]], bool]:
    """Return the pairs of feet that links of a part lead to, and whether one is single."""
    pairs, single = _pairs(urdf, part)
    if "ankle" in part:
        # The ankle's axes come in either order, and the foot is what the last one moves.
        pairs = list(dict.fromkeys((_leg_end(urdf, a), _leg_end(urdf, b)) for a, b in pairs))
    return pairs, single


def _pairs(urdf: Urdf, part: str) -> tuple[list[tuple[str, str]], bool]:
    """Return the pairs of links of a part, the plainest names first, and whether one is single."""
    pairs, single = [], False
    for name in urdf.links:
        if part not in " ".join(_words(name)):
            continue
        mirrored = mirror(name)
        if mirrored is None:
            continue
        if mirrored not in urdf.links:
            single = True
        elif side_of(name) == "left":
            pairs.append((name, mirrored))
    # `l_foot` beside `l_foot_dh_frame`: the plainer name is the link itself.
    pairs.sort(key=lambda pair: len(pair[0]))
    return _one_per_body(urdf, pairs), single


def _one_per_body(urdf: Urdf, pairs: list[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return the first pair of each body: links that fixed joints connect are one foot."""
    parents = {joint.child: joint.parent for joint in urdf.joints if joint.type == "fixed"}

    def body(link: str) -> str:
        above = {link}
        while parents.get(link, link) not in above:
            link = parents[link]
            above.add(link)
        return link

    # Of names of equal length, the link that carries the other is the foot itself.
    ranked = sorted(pairs, key=lambda pair: (len(pair[0]), pair[0] != body(pair[0])))
    first: dict[str, tuple[str, str]] = {}
    for pair in ranked:
        first.setdefault(body(pair[0]), pair)
    return list(first.values())


def _leg_end(urdf: Urdf, link: str) -> str:
    """Return the last link of the chain of moving joints that goes on from a link."""
    while True:
        fixed = [link]
        onward: list[str] = []
        while fixed:
            parent = fixed.pop()
            for joint in urdf.joints:
                if joint.parent == parent:
                    (fixed if joint.type == "fixed" else onward).append(joint.child)
        if len(onward) != 1:
            return link
        link = onward[0]


def side_of(name: str) -> str | None:
    """Return `left` or `right` if the name contains one of them, as a word or as its initial."""
    words = _words(name)
    for left, right in _SIDES:
        if left in words and right not in words:
            return "left"
        if right in words and left not in words:
            return "right"
    return None


def mirror(name: str) -> str | None:
    """Return the name with left and right exchanged and its capitals kept, or None."""
    for left, right in _SIDES:
        for a, b in ((left, right), (right, left)):
            words = _split(name)
            hits = [i for i, word in enumerate(words) if word.lower() == a]
            if hits:
                words[hits[0]] = _with_case_of(b, words[hits[0]])
                return "".join(words)
    return None


def checked_foot_link(urdf: Urdf, name: str, side: str) -> str:
    """Return the stated foot link.

    Raises:
        RobotDescriptionError: the file has no such link.
    """
    if name not in urdf.links:
        raise RobotDescriptionError(
            f"{urdf.path}: the {side.replace('_', ' ')} foot is stated as '{name}', but the file "
            f"has no such link{did_you_mean(name, urdf.links)}"
        )
    return name


def _split(name: str) -> list[str]:
    """Split `LAnkleRoll`, `l_ankle` or `leftfoot` into parts that join to the same name."""
    return _PARTS_OF_NAMES.findall(name)


def _words(name: str) -> list[str]:
    return [word.lower() for word in _split(name) if word[0].isalpha()]


def _with_case_of(word: str, model: str) -> str:
    if model.isupper():
        return word.upper()
    return word.capitalize() if model[0].isupper() else word
