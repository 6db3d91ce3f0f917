"""Compiles all kernels, in two processes: together they take about two minutes on two cores."""

from __future__ import annotations

import subprocess
import sys

# Imports that compile kernels; the two take about the same time.
_COMPILING = (
    "import wbc.qp.kernels.hierarchy",
    "import wbc.qp.compiled, wbc.qp.kernels.velocity, wbc.estimation.kernels, wbc.gait.kernels, "
    "wbc.limits.kernels, wbc.walking.kernels",
)


def compile_kernels() -> int:
    """Compile them into the cache; returns the exit status."""
    processes = [subprocess.Popen([sys.executable, "-c", code]) for code in _COMPILING]
    return max(process.wait() for process in processes)


if __name__ == "__main__":
    sys.exit(compile_kernels())
