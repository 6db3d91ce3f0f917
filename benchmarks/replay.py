"""Measures what `wbc replay` takes for a long log: memory, and the time to show a moment of it.

The moments are spread over the run, in random order; with each, eight seconds before it are read
for the trails. The memory is the largest of this process, with Python, Pinocchio and the meshes.

    wbc walk --duration 300 --no-view --log long.mcap
    python benchmarks/replay.py long.mcap
"""

from __future__ import annotations

import argparse
import json
import resource
import time
from pathlib import Path

import numpy as np

from wbc.log import LoggedTimeline, logged_robot
from wbc.view.replay import Replay


def measure(path: Path, moments: int) -> dict[str, float]:
    """Return memory, MB, and times, s, of a replay in this process."""
    start = time.perf_counter()
    timeline = LoggedTimeline(path)
    read = time.perf_counter() - start
    robot = logged_robot(timeline.overview.robot_info)
    scene = Replay(robot, timeline, boxes=timeline.overview.log.boxes()).new_scene()
    for _ in scene.scene.commands():
        pass
    shown = []
    times = np.linspace(timeline.start, timeline.end, moments)
    for moment in np.random.default_rng(0).permutation(times):
        start = time.perf_counter()
        scene.show(float(moment))
        shown.append(time.perf_counter() - start)
    return {
        "megabytes": path.stat().st_size / 1e6,
        "read_s": read,
        "show_p50_s": float(np.median(shown)),
        "show_max_s": max(shown),
        "max_rss_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def main() -> None:
    """Measure, print the figures and write the JSON file."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("log", type=Path)
    parser.add_argument("--moments", type=int, default=20, help="times to show")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    options = parser.parse_args()
    row = measure(options.log, options.moments)
    print(
        f"{row['megabytes']:.0f} MB: read in {row['read_s']:.1f} s; largest memory "
        f"{row['max_rss_mb']:.0f} MB; a time is shown in {row['show_p50_s']:.2f} s (median), "
        f"{row['show_max_s']:.2f} s (max)"
    )
    if options.json:
        options.json.write_text(json.dumps(row, indent=1) + "\n")


if __name__ == "__main__":
    main()
