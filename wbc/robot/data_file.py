"""Robot data files: what cannot be derived from a robot's description, in TOML.

urdf = "example-robot-data:talos_data/robots/talos_reduced.urdf"
left_foot = "left_sole_link"
right_foot = "right_sole_link"
armature = 0.05                # kg·m², rotor inertia seen at the joint
[nominal_posture]              # rad
left_knee = 0.4
right_knee = 0.4

`docs/robots.md` documents each key.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from fnmatch import fnmatchcase
from numbers import Real
from pathlib import Path
from typing import Any

from wbc.errors import RobotDescriptionError, did_you_mean, short_repr
from wbc.robot.packages import EXAMPLES, example_robot_data

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


@dataclass(frozen=True, slots=True)
class RobotData:
    """The properties of a robot that its data file or the caller of `load` states.

    Attributes:
        urdf: path of the description.
        name: the robot's name; empty for the one in the URDF.
        srdf: path of the semantic description, if stated.
        left_foot: link that carries the left sole.
        right_foot: link that carries the right sole.
        feet: links of the four feet of a quadruped: front left, front right, hind left, hind
            right.
        torso: link of the upper trunk.
        imu: link or frame where the inertial unit sits.
        nominal_posture: joint name to position, rad or m.
        group_state: name of the SRDF `group_state` to stand in.
        armature: rotor inertia at the joint, kg·m² (kg for sliding joints):
            one number, or by joint name with `default` for the others.
        effort_limits: joint name to effort limit, N·m or N.
        velocity_limits: joint name to velocity limit, rad/s or m/s.
        sole: rectangle stated for both feet when they have no geometry:
            `height` (sole plane in the foot link, m), `length`, `width`, and
            `center` (x, y).
        fixed_joints: joints to weld at zero, by name or pattern (`*Finger*`).
        respect_up_axis: whether the Collada meshes mean their `<up_axis>`; None: the soles tell.
        package_dirs: folders that hold packages.
        source: name of the data file, for messages.
        arguments: keys that the caller of `load` states.
    """

    urdf: Path
    name: str = ""
    srdf: Path | None = None
    left_foot: str | None = None
    right_foot: str | None = None
    feet: tuple[str, ...] = ()
    torso: str | None = None
    imu: str | None = None
    nominal_posture: Mapping[str, float] = field(default_factory=dict)
    group_state: str | None = None
    armature: float | Mapping[str, float] = 0.0
    effort_limits: Mapping[str, float] = field(default_factory=dict)
    velocity_limits: Mapping[str, float] = field(default_factory=dict)
    sole: Mapping[str, Any] = field(default_factory=dict)
    fixed_joints: tuple[str, ...] = ()
    respect_up_axis: bool | None = None
    package_dirs: tuple[str | Path, ...] = ()
    source: str = "argument"
    arguments: frozenset[str] = frozenset()

    def source_of(self, key: str) -> str:
        """Return the origin of a key, for messages: `argument`, or the name of the data file."""
        return "argument" if key in self.arguments else self.source

    def statement_of(self, key: str) -> str | None:
        """Return the origin of a key, or None if it is not stated."""
        return self.source_of(key) if getattr(self, key) else None

    def with_arguments(self, **arguments: Any) -> RobotData:
        """Return these data with what the caller of `load` states instead; None states nothing.

        Limits and package folders are added to those of the data file; the rest replaces it.

        Raises:
            RobotDescriptionError: an unknown key, or a value of the wrong kind.
        """
        stated = {key: value for key, value in arguments.items() if value is not None}
        check_values(stated, "argument")
        changes: dict[str, Any] = dict(stated)
        if "srdf" in stated:
            changes["srdf"] = Path(stated["srdf"]).expanduser().resolve()
            # An SRDF is given for its posture; the data file's own would hide it.
            changes.setdefault("nominal_posture", {})
        if "feet" in stated:
            changes["feet"] = tuple(stated["feet"])
            # Whoever states four feet does not mean the two of the data file, nor the reverse.
            changes |= {"left_foot": None, "right_foot": None}
        elif {"left_foot", "right_foot"} & set(stated):
            changes["feet"] = ()
        if "fixed_joints" in stated:
            changes["fixed_joints"] = tuple(stated["fixed_joints"])
        for key in ("effort_limits", "velocity_limits"):
            if key in stated:
                changes[key] = {**getattr(self, key), **stated[key]}
        if "package_dirs" in stated:
            changes["package_dirs"] = (*stated["package_dirs"], *self.package_dirs)
        return replace(self, **changes, arguments=self.arguments | set(stated))

    def without_fixed_joints(self) -> RobotData:
        """These data less the postures, armatures and limits of joints that they fix."""
        if not self.fixed_joints:
            return self
        tables = {key: getattr(self, key) for key in _TABLES}
        moving: dict[str, Any] = {
            key: {name: x for name, x in table.items() if not self.fixes(name)}
            for key, table in tables.items()
            if isinstance(table, Mapping)
        }
        return replace(self, **moving)

    def fixes(self, joint: str) -> bool:
        """Whether a name or pattern among `fixed_joints` is that of a joint."""
        return any(fnmatchcase(joint, pattern) for pattern in self.fixed_joints)


KEYS = tuple(f.name for f in fields(RobotData) if f.name not in ("source", "arguments"))
SOLE_KEYS = ("height", "length", "width", "center")


def read_data(path: Path) -> RobotData:
    """Read a robot data file.

    Raises:
        RobotDescriptionError: unreadable or malformed TOML, an unknown key, a
            value of the wrong kind, or no `urdf`.
    """
    try:
        with path.open("rb") as file:
            table = tomllib.load(file)
    except OSError as error:
        raise RobotDescriptionError(
            f"cannot read {path}: {error.strerror or error}; give the path of a readable file"
        ) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise RobotDescriptionError(
            f"{path}: malformed TOML: {error}; correct that line (text needs quotes)"
        ) from error
    if not isinstance(table.get("urdf"), str):
        raise RobotDescriptionError(f'{path}: no urdf; state  urdf = "path/of/the.urdf"')
    check_values(table, str(path))
    table["name"] = table.get("name", path.stem)
    for key in ("urdf", "srdf"):
        if key in table:
            table[key] = locate(table[key], path.parent, path)
    table["feet"] = tuple(table.get("feet", ()))
    table["fixed_joints"] = tuple(table.get("fixed_joints", ()))
    table["package_dirs"] = tuple(
        (path.parent / Path(folder).expanduser()).resolve()
        for folder in table.get("package_dirs", ())
    )
    return RobotData(**table, source=path.name)


def locate(address: str, folder: Path, source: Path) -> Path:
    """A path in a data file: absolute, beside the file, or `example-robot-data:…`.

    Raises:
        RobotDescriptionError: example-robot-data is not installed.
    """
    if not address.startswith(EXAMPLES + ":"):
        return (folder / Path(address).expanduser()).resolve()
    root = example_robot_data()
    if root is None:
        raise RobotDescriptionError(
            f"{source}: needs {EXAMPLES}, which is not installed; run  pip install {EXAMPLES}"
        )
    return root / "robots" / address.split(":", 1)[1]


def check_values(values: Mapping[str, Any], source: str) -> None:
    """Refuse unknown keys, and values that cannot be what their key means.

    Args:
        values: values by key of a robot data file.
        source: origin of the values, for the message.

    Raises:
        RobotDescriptionError: names the key, the value and what it must be.
    """
    for key, value in values.items():
        if key not in KEYS:
            raise RobotDescriptionError(f"{source}: unknown key '{key}'{did_you_mean(key, KEYS)}")
        accepts, wanted = _CHECKS[key]
        if key in _TABLES and isinstance(value, Mapping):
            for entry, number in value.items():
                if not accepts(number):
                    raise _wrong(source, f"{key}.{entry}", number, wanted)
        elif key in _TABLES and key != "armature":
            raise _wrong(source, key, value, "a table of joint names and numbers")
        elif not accepts(value):
            raise _wrong(source, key, value, wanted)
    stated = [key for key in ("left_foot", "right_foot") if key in values]
    if "feet" in values and stated:
        raise RobotDescriptionError(
            f"{source}: states both feet and {stated[0]}; state feet for a quadruped, left_foot "
            "and right_foot for a robot on two legs"
        )
    if "sole" in values:
        _check_sole(values["sole"], source)


def _check_sole(sole: Mapping[str, Any], source: str) -> None:
    """The sizes and the centre of a stated sole."""
    for key in sole:
        if key not in SOLE_KEYS:
            raise RobotDescriptionError(
                f"{source}: the sole has no '{key}'{did_you_mean(key, SOLE_KEYS)}"
            )
    for key in ("height", "length", "width") if sole else ():
        if key not in sole:
            raise RobotDescriptionError(
                f"{source}: the sole has no {key}; state height, length and width, m"
            )
        if not _is_finite(sole[key]):
            raise _wrong(source, f"sole.{key}", sole[key], "a finite number, m")
        if key != "height" and sole[key] < 0.0:
            raise _wrong(source, f"sole.{key}", sole[key], "zero or positive, m")
    center = sole.get("center", (0.0, 0.0))
    try:
        right = len(center) == 2 and all(_is_finite(x) for x in center)
    except TypeError:
        right = False
    if not right:
        raise _wrong(source, "sole.center", center, "two finite numbers (x, y), m")


def _wrong(source: str, key: str, value: object, wanted: str) -> RobotDescriptionError:
    return RobotDescriptionError(f"{source}: '{key}' is {short_repr(value)}; it must be {wanted}")


def _is_finite(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)


def _is_zero_or_positive(value: object) -> bool:
    return _is_finite(value) and float(value) >= 0.0  # type: ignore[arg-type]


def _is_positive(value: object) -> bool:
    return _is_finite(value) and float(value) > 0.0  # type: ignore[arg-type]


def _is_text(value: object) -> bool:
    return isinstance(value, str)


def _is_path(value: object) -> bool:
    return isinstance(value, (str, Path))


def _is_list_of(accepts: Callable[[object], bool]) -> Callable[[object], bool]:
    def check(value: object) -> bool:
        return isinstance(value, (list, tuple, set, frozenset)) and all(map(accepts, value))

    return check


def _is_four_names(value: object) -> bool:
    return isinstance(value, (list, tuple)) and all(map(_is_text, value)) and len({*value}) == 4


_NAME = (_is_text, "a name (text)")
_PATH = (_is_path, "a path (text)")
_TABLES = ("nominal_posture", "armature", "effort_limits", "velocity_limits")
_CHECKS: dict[str, tuple[Callable[[object], bool], str]] = {
    "urdf": _PATH,
    "name": _NAME,
    "srdf": _PATH,
    "left_foot": _NAME,
    "right_foot": _NAME,
    "feet": (
        _is_four_names,
        "the names of four links: front left, front right, hind left, hind right",
    ),
    "torso": _NAME,
    "imu": _NAME,
    "nominal_posture": (_is_finite, "a finite position, rad or m"),
    "group_state": _NAME,
    "armature": (
        _is_zero_or_positive,
        "zero or a positive rotor inertia, kg·m²: one number, or a table by joint name",
    ),
    "effort_limits": (_is_positive, "a positive effort, N·m or N"),
    "velocity_limits": (_is_positive, "a positive velocity, rad/s or m/s"),
    "sole": (lambda value: isinstance(value, Mapping), "a table of height, length and width, m"),
    "fixed_joints": (_is_list_of(_is_text), "a list of joint names or patterns, e.g. ['*Finger*']"),
    "respect_up_axis": (lambda value: isinstance(value, bool), "true or false"),
    "package_dirs": (_is_list_of(_is_path), "a list of folders, e.g. ['/home/me/workspace/src']"),
}
