"""Robot data files: what cannot be derived from a robot's description, in TOML.

urdf = "example-robot-data:talos_data/robots/talos_reduced.urdf"
left_foot = "left_sole_link"
right_foot = "right_sole_link"
armature = 0.05                # kg·m², rotor inertia seen at the joint
[nominal_posture]              # rad; joints that are left out stay at zero
left_knee = 0.4
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from wbc.errors import RobotDescriptionError, did_you_mean
from wbc.robot.packages import EXAMPLES, example_robot_data

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


@dataclass(frozen=True, slots=True)
class RobotData:
    """What is stated about a robot, by its data file or by the caller.

    Attributes:
        name: the robot's name.
        urdf: path of the description.
        srdf: path of the semantic description, if stated.
        left_foot: link that carries the left sole.
        right_foot: link that carries the right sole.
        torso: link of the upper trunk.
        imu: link or frame where the inertial unit sits.
        nominal_posture: joint name to position, rad or m.
        reference: name of the SRDF `group_state` to stand in.
        armature: rotor inertia at the joint, kg·m² (kg for sliding joints):
            one number, or by joint name with `default` for the others.
        effort_limits: joint name to effort limit, N·m or N.
        velocity_limits: joint name to velocity limit, rad/s or m/s.
        sole: rectangle stated for both feet when they have no geometry:
            `height` (sole plane in the foot link, m), `length`, `width`, and
            `center` (x, y).
        fixed_joints: joints to weld at zero, by name or pattern (`*Finger*`).
        respect_up_axis: whether the Collada meshes mean their `<up_axis>`.
        package_dirs: folders that hold packages.
        source: where these things are stated, for messages.
    """

    name: str
    urdf: Path
    srdf: Path | None = None
    left_foot: str | None = None
    right_foot: str | None = None
    torso: str | None = None
    imu: str | None = None
    nominal_posture: Mapping[str, float] = field(default_factory=dict)
    reference: str | None = None
    armature: float | Mapping[str, float] = 0.0
    effort_limits: Mapping[str, float] = field(default_factory=dict)
    velocity_limits: Mapping[str, float] = field(default_factory=dict)
    sole: Mapping[str, Any] = field(default_factory=dict)
    fixed_joints: tuple[str, ...] = ()
    respect_up_axis: bool = False
    package_dirs: tuple[str, ...] = ()
    source: str = "argument"

    def with_overrides(self, **overrides: Any) -> RobotData:
        """These data with what a caller states instead; None leaves a value as it is."""
        changes = {key: value for key, value in overrides.items() if value is not None}
        if "srdf" in changes:
            changes["srdf"] = Path(changes["srdf"]).expanduser().resolve()
            # An SRDF is given for its posture; the data file's own would hide it.
            changes.setdefault("nominal_posture", {})
        if "fixed_joints" in changes:
            changes["fixed_joints"] = tuple(changes["fixed_joints"])
        return replace(self, **changes) if changes else self


SOLE_KEYS = ("height", "length", "width", "center")
_TEXTS = ("left_foot", "right_foot", "torso", "imu", "reference")
_TABLES = ("nominal_posture", "effort_limits", "velocity_limits")
_KEYS = tuple(f.name for f in fields(RobotData) if f.name != "source")


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
        raise RobotDescriptionError(f"cannot read {path}: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise RobotDescriptionError(f"{path}: malformed TOML: {error}") from error
    for key in table:
        if key not in _KEYS:
            raise RobotDescriptionError(f"{path}: unknown key '{key}'{did_you_mean(key, _KEYS)}")
    if not isinstance(table.get("urdf"), str):
        raise RobotDescriptionError(f'{path}: no urdf; state  urdf = "path/of/the.urdf"')
    _check_kinds(path, table)
    table["name"] = table.get("name", path.stem)
    for key in ("urdf", "srdf"):
        if key in table:
            table[key] = locate(table[key], path.parent, path)
    table["fixed_joints"] = tuple(table.get("fixed_joints", ()))
    table["package_dirs"] = tuple(
        str((path.parent / folder).resolve()) for folder in table.get("package_dirs", ())
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


def _check_kinds(path: Path, table: dict[str, Any]) -> None:
    def wrong(key: str, wanted: str) -> RobotDescriptionError:
        return RobotDescriptionError(f"{path}: '{key}' is {table[key]!r}; it must be {wanted}")

    for key in _TEXTS:
        if key in table and not isinstance(table[key], str):
            raise wrong(key, "a name in quotes")
    for key in _TABLES:
        if key in table and not _is_number_table(table[key]):
            raise wrong(key, "a table of joint names and numbers")
    armature = table.get("armature", 0.0)
    if not (_is_number(armature) or _is_number_table(armature)):
        raise wrong("armature", "a number or a table of joint names and numbers")
    values = armature.values() if isinstance(armature, dict) else [armature]
    if any(value < 0.0 for value in values):
        raise wrong("armature", "positive or zero, in kg·m²")


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _is_number_table(value: object) -> bool:
    return isinstance(value, dict) and all(_is_number(v) for v in value.values())
