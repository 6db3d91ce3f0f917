"""What results depend on beside the grid: the versions of all that computes them."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import wbc
from wbc.robot.registry import data_file_folder
from wbc.trials.digest import path_digest, text_digest


@dataclass(frozen=True)
class Provenance:
    """Versions of the software that computed results.

    Attributes:
        wbc: version of this library.
        source: digest of this library's Python and robot files, which tells edited ones apart.
        pinocchio: version, likewise of the other packages.
    """

    wbc: str
    source: str
    pinocchio: str
    mujoco: str
    numpy: str
    numba: str
    scipy: str

    @classmethod
    def current(cls) -> Provenance:
        """Return that of this process."""
        names = {"pinocchio": "pin"}
        packages = ("pinocchio", "mujoco", "numpy", "numba", "scipy")
        versions = {name: _version(names.get(name, name)) for name in packages}
        return cls(wbc=wbc.__version__, source=_source_digest(), **versions)

    def differences(self, other: Provenance) -> tuple[str, ...]:
        """Return what differs from another one, in words."""
        mine, theirs = asdict(self), asdict(other)
        return tuple(
            "another source code of wbc"
            if name == "source"
            else f"{name} {mine[name]} instead of {theirs[name]}"
            for name in mine
            if mine[name] != theirs[name]
        )


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def _source_digest() -> str:
    code = path_digest(Path(wbc.__file__).parent, ("*.py",))
    return text_digest(code + path_digest(data_file_folder(), ("*.toml", "*.urdf", "*.srdf")))
