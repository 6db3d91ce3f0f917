"""The `wbc` command in a process of its own."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import wbc

ROOT = Path(wbc.__file__).parents[1]
QUICK = ("--robot", "simple_humanoid", "--no-view")


def environment(**variables: str) -> dict[str, str]:
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    return {**os.environ, "PYTHONPATH": path, **variables}


def start(*arguments: str, **options: object) -> subprocess.Popen[str]:
    """Start `wbc` with piped output."""
    settings = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "env": environment()}
    return subprocess.Popen(
        [sys.executable, "-m", "wbc", *arguments],
        stdin=subprocess.DEVNULL,
        text=True,
        encoding="utf-8",
        # A test run in the background ignores SIGINT, and so would the command.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        **{**settings, **options},
    )


def run(*arguments: str, **options: object) -> tuple[int, str, str]:
    """Run `wbc`; return exit code, standard output and standard error."""
    process = start(*arguments, **options)
    out, err = process.communicate(timeout=120)
    return process.returncode, out or "", err or ""
