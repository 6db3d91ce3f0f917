"""The robots that can be loaded by name: data files, then example-robot-data."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from wbc.errors import RobotDescriptionError, RobotNotFound, did_you_mean
from wbc.robot.data_file import RobotData, read_data
from wbc.robot.packages import example_robot_data

_HERE = Path(__file__).resolve().parent


def data_file_folder() -> Path:
    """Return the folder of the shipped data files: in the wheel, or `robots/` of a checkout."""
    inside = _HERE / "data"
    return inside if inside.is_dir() else _HERE.parents[1] / "robots"


def available() -> tuple[str, ...]:
    """Return the names of the robots that have a data file, sorted."""
    return tuple(sorted(path.stem for path in data_file_folder().glob("*.toml")))


def examples() -> tuple[str, ...]:
    """Return the names of the URDFs of example-robot-data, sorted.

    A name is the file's stem (`icub_reduced`), or where several folders share
    a stem, the path below `robots/` without its suffix.
    """
    return tuple(sorted(_examples()))


def find_robot(name_or_path: str | Path) -> RobotData:
    """Return what is stated about the robot of that name, or at that path.

    Raises:
        RobotNotFound: there is no such name and no such file.
        RobotDescriptionError: the data file is malformed.
    """
    text = str(name_or_path)
    path = Path(text).expanduser()
    if isinstance(name_or_path, str) and (data_file_folder() / f"{text}.toml").is_file():
        return read_data(data_file_folder() / f"{text}.toml")
    if path.is_file():
        if path.suffix == ".toml":
            return read_data(path.resolve())
        return RobotData(path.resolve())
    names = _examples()
    if text in names:
        return RobotData(names[text])
    root = example_robot_data()
    if root is not None and text.endswith(".urdf") and (root / "robots" / text).is_file():
        return RobotData(root / "robots" / text)
    if text.endswith("_description") and text.isidentifier():
        found = _of_robot_descriptions(text)
        if found is not None:
            return RobotData(found, name=text.removesuffix("_description"))
    if path.is_dir():
        raise RobotDescriptionError(f"{path} is a folder; give the path of the URDF inside it")
    if path.suffix or len(path.parts) > 1:
        raise RobotNotFound(f"there is no file {path}{_suggestion(text, names)}")
    raise RobotNotFound(f"there is no robot '{text}'{_suggestion(text, names)}")


def _of_robot_descriptions(name: str) -> Path | None:
    """Return the file of a description of the package robot_descriptions; None without it.

    The package brings names and addresses, and clones the description when it is imported.
    """
    try:
        module = import_module(f"robot_descriptions.{name}")
    except ModuleNotFoundError:
        return None
    for kind in ("URDF_PATH", "MJCF_PATH", "XACRO_PATH"):
        if path := getattr(module, kind, None):
            return Path(path).resolve()
    return None


def _suggestion(text: str, names: dict[str, Path]) -> str:
    stem = Path(text).stem
    if len(stem) < 2:
        return ""
    return did_you_mean(stem, dict.fromkeys((*available(), *names)))


def _examples() -> dict[str, Path]:
    root = example_robot_data()
    if root is None:
        return {}
    robots = root / "robots"
    by_stem: dict[str, list[Path]] = {}
    for path in robots.glob("*/*/*.urdf"):
        by_stem.setdefault(path.stem, []).append(path)
    names: dict[str, Path] = {}
    for stem, paths in by_stem.items():
        if len(paths) == 1:
            names[stem] = paths[0]
        for path in paths[: len(paths) if len(paths) > 1 else 0]:
            names[path.relative_to(robots).with_suffix("").as_posix()] = path
    return names
