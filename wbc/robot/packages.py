"""Resolution of `package://`, `file://` and relative mesh addresses to files."""

from __future__ import annotations

import os
import re
import sysconfig
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path

import numpy as np
import pinocchio as pin

EXAMPLES = "example-robot-data"
PACKAGE_NAME = re.compile(rb"<name>\s*([^<\s]+)\s*</name>")
UNIT = re.compile(rb"<unit\b[^>]*\bmeter\s*=\s*[\"']([0-9.eE+-]+)[\"']")
UP_AXIS = re.compile(rb"<up_axis>\s*(\w+)\s*</up_axis>")


def example_robot_data() -> Path | None:
    """Return the `share/example-robot-data` folder of the installed package, or None.

    The package holds data only, under the prefix that Pinocchio's wheel shares
    (`cmeel.prefix`), so no module tells where it is.
    """
    # Beside Pinocchio's wheel, or under the common prefix of a conda or ROS installation.
    prefixes = [Path(sysconfig.get_path("purelib")) / "cmeel.prefix"]
    prefixes += list(Path(pin.__file__).parents)[:6]
    prefixes += [Path(p) for p in os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep) if p]
    for prefix in prefixes:
        if (prefix / "share" / EXAMPLES / "robots").is_dir():
            return prefix / "share" / EXAMPLES
    return _of_distribution()


def _of_distribution() -> Path | None:
    """Return the folder that the wheel's metadata list; slower than looking where it usually is."""
    from importlib import metadata

    try:
        files = metadata.files(EXAMPLES) or []
    except metadata.PackageNotFoundError:
        return None
    for file in files:
        if file.parts[-2:] == (EXAMPLES, "package.xml"):
            return Path(str(file.locate())).parent
    return None


def search_folders(urdf: Path, extra: Iterable[str | Path] = ()) -> tuple[Path, ...]:
    """Return the folders that may hold packages, the caller's first, without duplicates."""
    folders = [Path(folder).expanduser().resolve() for folder in extra]
    # A URDF usually lies inside the package whose meshes it names.
    folders += list(urdf.resolve().parents)[:-1]
    folders += [
        Path(folder)
        for variable in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")
        for prefix in os.environ.get(variable, "").split(os.pathsep)
        if prefix
        for folder in (prefix, os.path.join(prefix, "share"))
    ]
    examples = example_robot_data()
    if examples is not None:
        folders += [examples.parent, examples / "robots"]
    return tuple(dict.fromkeys(folders))


def package_folder(package: str, folders: Iterable[Path]) -> Path | None:
    """Return the folder of a package, or None if no search folder has it."""
    for folder in folders:
        if folder.name == package and folder.is_dir():
            return folder
        if (folder / package).is_dir():
            return folder / package
    return next((folder for folder in folders if declared_package(folder) == package), None)


@lru_cache(maxsize=256)
def declared_package(folder: Path) -> str | None:
    """Return the name that the `package.xml` in a folder declares; None without it.

    A clone of a repository often has another name than the package that it holds.
    """
    try:
        found = PACKAGE_NAME.search((folder / "package.xml").read_bytes())
    except OSError:
        return None
    return found.group(1).decode(errors="replace") if found is not None else None


def resolve(address: str, urdf: Path, folders: Iterable[Path]) -> Path | None:
    """Return the file that a mesh address refers to, or None if there is none.

    `package:///name/…` with a third slash, which some exporters write, is read
    as `package://name/…`.
    """
    if address.startswith(("package://", "model://")):
        inside = address.split("://", 1)[1].lstrip("/")
        package, _, rest = inside.partition("/")
        candidates = []
        for folder in folders:
            candidates.append(folder / inside)
            if package in (folder.name, declared_package(folder)):
                candidates.append(folder / rest)
    elif address.startswith("file://"):
        candidates = [Path(address[len("file://") :])]
    else:
        candidates = [urdf.parent / address]
    return next((path for path in candidates if path.is_file()), None)


def with_file_addresses(text: str, urdf: Path, folders: Iterable[Path]) -> str:
    """Return a URDF in which `file://` addresses replace those of meshes that exist.

    Args:
        text: the description.
        urdf: its path, to which relative addresses refer.
        folders: folders that may hold packages.
    """
    found = tuple(folders)

    def replaced(match: re.Match[str]) -> str:
        path = resolve(match[2], urdf, found)
        return match[0] if path is None else f"{match[1]}file://{path.resolve()}{match[3]}"

    return re.sub(r"""(<mesh\b[^>]*?\bfilename\s*=\s*["'])([^"']+)(["'])""", replaced, text)


def mesh_unit(mesh: Path) -> float:
    """Return the unit of a Collada file, m; ROS tools apply it, Pinocchio does not."""
    if mesh.suffix.lower() == ".dae" and mesh.is_file():
        found = UNIT.search(mesh.read_bytes()[:20000])
        if found is not None and (metres := float(found.group(1))) > 0.0:
            return metres
    return 1.0


def up_axis_rotation(mesh: Path) -> np.ndarray:
    """Return the (3, 3) rotation from a Collada file's own axes to axes with z up.

    ROS tools and Pinocchio ignore `<up_axis>`, and most robots are written for that. A few
    (iCub) need it applied.
    """
    if mesh.suffix.lower() == ".dae":
        found = UP_AXIS.search(mesh.read_bytes()[:20000])
        if found is not None and found.group(1) == b"Y_UP":
            return np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    return np.eye(3)
