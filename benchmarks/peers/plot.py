"""Plots the comparison."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from peers.compare import Comparison

SHOWN = {  # key: (label, colour)
    "wbc": ("wbc", "#1f5fa8"),
    "tsid": ("TSID (eiquadprog-fast)", "#d9822b"),
    "placo": ("placo DynamicsSolver", "#5b9a53"),
    "pink": ("pink solve_ik (velocities only)", "#b9b9b9"),
    "placo-ik": ("placo KinematicsSolver (velocities only)", "#dcdcdc"),
}
LIGHT = ("pink", "placo-ik")  # colours that need dark figures


def draw(found: Comparison, path: Path) -> None:
    """Draw the medians as bars with a line up to the 99th percentile, one group per case.

    Raises:
        SystemExit: matplotlib is not installed.
    """
    try:
        import matplotlib
    except ImportError:
        raise SystemExit("the plot needs matplotlib: pip install 'wbc[plots]'") from None
    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    keys = [library.key for library in found.libraries if library.key in SHOWN]
    keys.sort(key=list(SHOWN).index)
    width = 0.84 / max(len(keys), 1)
    fig, ax = plt.subplots(figsize=(9.6, 4.0), layout="constrained")
    for n, key in enumerate(keys):
        label, colour = SHOWN[key]
        middles, heights, reach = [], [], []
        for group, case in enumerate(found.cases):
            cpu = found.figures(case.name, key)
            if cpu is not None:
                middles.append(group + (n - 0.5 * (len(keys) - 1)) * width)
                heights.append(cpu.p50)
                reach.append(max(cpu.p99_of_ticks - cpu.p50, 0.0))
        if not middles:
            continue
        error = np.array([np.zeros(len(reach)), reach])
        ax.bar(
            middles,
            heights,
            0.92 * width,
            yerr=error,
            label=label,
            color=colour,
            error_kw={"elinewidth": 1.0, "ecolor": "#333333", "capsize": 2.0},
        )
        for x, height in zip(middles, heights, strict=True):
            ax.annotate(
                f"{height:.0f}",
                (x, 0.0),
                xytext=(0, 3),
                textcoords="offset points",
                ha="center",
                fontsize=8,
                fontweight="bold",
                color="black" if key in LIGHT else "white",
            )
    ax.set_xticks(range(len(found.cases)), [case.title for case in found.cases])
    ax.set_ylabel("µs per tick")
    ax.set_title(
        "One tick, from (q, v) to torques: median, and a line up to the 99th percentile of ticks",
        fontsize=10,
        loc="left",
    )
    ax.tick_params(axis="x", length=0)
    ax.spines[["top", "right"]].set_visible(False)
    ax.grid(axis="y", color="#e6e6e6", linewidth=0.8)
    ax.set_axisbelow(True)
    ax.margins(x=0.01, y=0.08)
    fig.legend(loc="outside lower center", ncols=5, frameon=False, fontsize=8)
    fig.savefig(path, dpi=160)
    plt.close(fig)
