"""The files that pages may name: those that they have sent, and those where wbc was started."""

from __future__ import annotations

import itertools
import re
import shutil
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from wbc.errors import did_you_mean, short_repr
from wbc.teleop import CommandRefused

ROBOT_SUFFIXES = (".urdf",)
_ARCHIVE = ".zip"
_MOTION_SUFFIXES = (".csv", ".yaml", ".yml")
_ACCEPTED = (*ROBOT_SUFFIXES, _ARCHIVE, *_MOTION_SUFFIXES)
_NAME = re.compile(r"\w[\w .+-]{0,99}")
_MAX_UNPACKED = 1 << 29  # bytes
_MAX_MEMBERS = 10_000


class Uploads:
    """Keeps the files that pages send, and finds files by their names.

    A page knows names only, never paths: it cannot reach any other file of this machine.

    Args:
        folder: Where the files are kept.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        taken = [int(path.name) for path in self._sent]
        self._numbers = itertools.count(1 + max(taken, default=0))

    @property
    def names(self) -> list[str]:
        """The names of the files that can be found."""
        return sorted(self._files((*ROBOT_SUFFIXES, *_MOTION_SUFFIXES)))

    def find(self, name: Any, suffixes: Sequence[str]) -> Path:
        """Return the path of the file of a name, the one that was sent last.

        Raises:
            CommandRefused: There is none.
        """
        files = self._files(suffixes)
        if name not in files:
            near = did_you_mean(name, files) if isinstance(name, str) else ""
            raise CommandRefused(f"no file {short_repr(name)} ({', '.join(suffixes)}){near}")
        return files[name]

    def save(self, name: str, content: bytes) -> str:
        """Keep a file; return the name by which it is found.

        An archive is unpacked; it contains one robot description, beside its meshes.

        Raises:
            CommandRefused: The name or the archive is not accepted.
        """
        suffix = Path(name).suffix.lower()
        if suffix not in _ACCEPTED or not _NAME.fullmatch(name):
            raise CommandRefused(
                f"{short_repr(name)} is not accepted: a file is {', '.join(_ACCEPTED)}"
            )
        folder = self._folder / str(next(self._numbers))
        folder.mkdir()
        if suffix != _ARCHIVE:
            (folder / name).write_bytes(content)
            found = [folder / name]
        else:
            (folder / name).write_bytes(content)
            try:
                found = _unpack(folder / name, folder)
            except CommandRefused:
                shutil.rmtree(folder)
                raise
        if suffix not in _MOTION_SUFFIXES and b"xacro:" in found[0].read_bytes():
            shutil.rmtree(folder)
            raise CommandRefused(f"{found[0].name} is xacro: expand it to a URDF first")
        return found[0].name

    @property
    def _sent(self) -> list[Path]:
        """The folders of what was sent, in the order in which it came."""
        folders = [path for path in self._folder.iterdir() if path.name.isdecimal()]
        return sorted(folders, key=lambda path: int(path.name))

    def _files(self, suffixes: Sequence[str]) -> dict[str, Path]:
        """Return the paths by their names; later files take the place of earlier ones."""
        here = Path.cwd().glob("*")
        paths = (*here, *(path for folder in self._sent for path in sorted(folder.rglob("*"))))
        return {
            path.name: path
            for path in paths
            if path.suffix.lower() in suffixes and path.is_file() and not path.is_symlink()
        }


def _unpack(archive: Path, folder: Path) -> list[Path]:
    """Unpack an archive into a folder; return the robot description in it.

    Raises:
        CommandRefused: It is no archive, too large, or does not contain one description.
    """
    try:
        with zipfile.ZipFile(archive) as packed:
            members = packed.infolist()
            if len(members) > _MAX_MEMBERS or sum(m.file_size for m in members) > _MAX_UNPACKED:
                raise CommandRefused(
                    f"{archive.name} is too large: at most {_MAX_MEMBERS} files of "
                    f"{_MAX_UNPACKED >> 20} MB together"
                )
            packed.extractall(folder)  # never outside of the folder
    except (zipfile.BadZipFile, OSError, RuntimeError, NotImplementedError) as error:
        raise CommandRefused(f"{archive.name} cannot be unpacked: {error}") from error
    found = sorted(path for path in folder.rglob("*") if path.suffix.lower() in ROBOT_SUFFIXES)
    if len(found) != 1:
        names = ", ".join(path.name for path in found[:5]) or "none"
        raise CommandRefused(
            f"{archive.name} contains {len(found)} URDF files ({names}); it must contain one"
        )
    return found
