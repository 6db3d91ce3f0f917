"""What results depend on beside the grid: the versions of all that computes them."""

from __future__ import annotations

import hashlib
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import wbc


@dataclass(frozen=True)
class Provenance:
    """Versions of the software that computed results.

    Attributes:
        wbc: version of this library.
        source: digest of this library's Python files, which also tells edited ones apart.
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
    folder, digest = Path(wbc.__file__).parent, hashlib.blake2b(digest_size=8)
    for path in sorted(folder.rglob("*.py")):
        digest.update(path.relative_to(folder).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()
