"""Creates the peers' environments from pinned requirements and keeps them until these change."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

LISTS = Path(__file__).parent
STAMP = "made-from"


class EnvironmentFailedError(RuntimeError):
    """An environment could not be created; the message states the reason and the remedy."""


def default_folder() -> Path:
    """Return the default folder of the environments."""
    cache = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(cache) / "wbc" / "peers"


def fingerprint(requirements: Path) -> str:
    """Return a hash of the pinned requirements and of the Python that creates the environment."""
    text = f"{sys.version_info[:2]} {sys.base_prefix}\n{requirements.read_text()}"
    return hashlib.sha256(text.encode()).hexdigest()


def prepare(name: str, folder: Path) -> Path:
    """Return the interpreter of an environment; create it if it is missing or out of date.

    Raises:
        EnvironmentFailedError: venv or pip failed.
    """
    requirements = LISTS / f"requirements-{name}.txt"
    home = folder.expanduser().resolve() / name
    python = home / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    stamp = home / STAMP
    wanted = fingerprint(requirements)
    if python.exists() and stamp.exists() and stamp.read_text() == wanted:
        print(f"{name}: using environment {home}")
        return python
    print(f"{name}: creating environment {home} from {requirements.name} …", flush=True)
    shutil.rmtree(home, ignore_errors=True)
    _run(name, [sys.executable, "-m", "venv", str(home)], "a virtual environment")
    pip = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    _run(name, [*pip, "--no-deps", "-r", str(requirements)], "the packages of the pinned list")
    stamp.write_text(wanted)
    return python


def _run(name: str, command: list[str], what: str) -> None:
    # Without the caller's PYTHONPATH, whose packages would count as installed.
    outside = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    try:
        done = subprocess.run(command, env=outside, capture_output=True, text=True)
    except OSError as error:
        raise EnvironmentFailedError(f"{name}: cannot run {command[0]}: {error}") from error
    if done.returncode != 0:
        said = (done.stderr.strip() or done.stdout.strip()).splitlines()[-6:]
        raise EnvironmentFailedError(
            f"{name}: could not create {what} with Python {sys.version.split()[0]}; run by hand\n"
            f"    {' '.join(command)}\n" + "\n".join(f"    | {line}" for line in said)
        )
