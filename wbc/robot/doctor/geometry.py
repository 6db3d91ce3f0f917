"""Checks of the visual and collision shapes and of their mesh files."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path

from wbc.robot.finding import Finding
from wbc.robot.geometry import shape_defect
from wbc.robot.packages import package_folder, resolve
from wbc.robot.urdf import Urdf


def check_shapes(urdf: Urdf) -> list[Finding]:
    """Return findings on shapes without geometry, size or readable numbers."""
    return [
        Finding(
            "warning",
            name,
            what,
            "the shape is left out: it is not drawn, and a foot does not stand on it",
            "state a box, cylinder, sphere or mesh with its sizes in m",
            "broken-shape",
        )
        for name, link in urdf.links.items()
        for tag in ("visual", "collision")
        for element in link.findall(tag)
        if (what := shape_defect(urdf, element)) is not None
    ]


def check_meshes(urdf: Urdf, folders: tuple[Path, ...]) -> list[Finding]:
    """Return findings on packages that are not found (one each), missing files and empty files."""
    missing_packages: dict[str, list[str]] = defaultdict(list)
    missing_files: dict[str, list[str]] = defaultdict(list)
    empty: dict[str, list[str]] = defaultdict(list)
    for name, link in urdf.links.items():
        for mesh in link.iterfind(".//geometry/mesh"):
            address = mesh.get("filename", "")
            path = resolve(address, urdf.path, folders)
            if path is not None:
                if path.stat().st_size == 0:
                    empty[address].append(name)
                continue
            package = package_of(address)
            if package and package_folder(package, folders) is None:
                missing_packages[package].append(name)
            else:
                missing_files[address].append(name)
    return [
        *(_package(name, links) for name, links in missing_packages.items()),
        *(_file(address, links) for address, links in missing_files.items()),
        *(_empty(address, links) for address, links in empty.items()),
    ]


def package_of(address: str) -> str | None:
    """Return the package's name in a `package://` address, or None."""
    scheme, found, rest = address.partition("://")
    if not found or scheme not in ("package", "model"):
        return None
    return rest.lstrip("/").partition("/")[0]


def _package(package: str, links: list[str]) -> Finding:
    return Finding(
        "warning",
        links[0],
        f"package://{package} is in no search folder; it has {len(links)} meshes ({_list(links)})",
        "these links are not drawn, and a foot among them has no sole",
        f"state package_dirs=… with the folder that contains '{package}', or set ROS_PACKAGE_PATH",
        "unresolved-package",
    )


def _file(address: str, links: list[str]) -> Finding:
    return Finding(
        "warning",
        links[0],
        f"its mesh {address or '(no filename)'} is missing ({_list(links)})",
        "the link is not drawn; a foot without a mesh has no sole",
        "copy the file there, correct the address, or use a box, cylinder or sphere",
        "missing-mesh",
    )


def _empty(address: str, links: list[str]) -> Finding:
    return Finding(
        "warning",
        links[0],
        f"its mesh {address} is an empty file ({_list(links)})",
        "it cannot be read",
        "fetch it again (a large-file store may have left a stub)",
        "empty-mesh",
    )


def _list(links: list[str]) -> str:
    names = list(dict.fromkeys(links))
    if len(names) == 1:
        return names[0]
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
