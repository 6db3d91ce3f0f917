"""Simulates the walks of each robot: the walking table of the README.

Every run is in MuJoCo with physics at 1 kHz, friction 0.8 unless told otherwise, the URDF's torque
limits, noisy sensors (encoders, joint velocities, IMU, foot forces) and without ground truth for
the walker. A cell passes if the robot does not fall and reaches its goal, no QP fails, and no
torque and no joint position exceeds its limit.

    python benchmarks/walk.py                     # all robots, 5 seeds
    python benchmarks/walk.py --robot g1 --seeds 2
    python benchmarks/walk.py --no-foot-sensors   # contact from joint torques and IMU
    python benchmarks/walk.py --friction 0.3 --stop-from 0.3   # slippery ground
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import json
import statistics
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

import wbc
from wbc.trials import Scenario, circle, forward, run_scenario, sideways, stop_and_stand, turn

SCENARIOS: dict[str, list[Scenario]] = {
    "talos": [
        forward(10.0, 0.53, min_cruise_speed=0.5),
        forward(10.0, 1.0, min_cruise_speed=0.95),
        sideways(2.0, 0.15),
        turn(180.0, 0.3),
        circle(1.0, 0.25),
        forward(2.0, -0.2),
        stop_and_stand(0.5),
    ],
    "g1": [
        forward(10.0, 0.39, min_cruise_speed=0.35),
        forward(10.0, 1.0, min_cruise_speed=0.95),
        turn(90.0, 0.3),
        sideways(1.0, 0.1),
        stop_and_stand(0.35),
    ],
    "simple_humanoid": [
        forward(10.0, 0.43, min_cruise_speed=0.4),
        forward(10.0, 0.8, min_cruise_speed=0.76),
        turn(90.0, 0.3),
        sideways(1.0, 0.1),
        stop_and_stand(0.4),
    ],
    "romeo": [
        forward(10.0, 0.22, min_cruise_speed=0.2),
        forward(10.0, 0.3, min_cruise_speed=0.28),
        stop_and_stand(0.2),
    ],
}


@dataclass(frozen=True)
class Variant:
    """What may differ from the walking table.

    Attributes:
        foot_sensors: the soles have force sensors.
        friction: Coulomb coefficient between soles and ground.
        stop_from: instead of the scenarios, stop from this speed and stand, m/s.
    """

    foot_sensors: bool
    friction: float
    stop_from: float | None

    def scenarios(self, name: str) -> list[Scenario]:
        """Return the scenarios of a robot."""
        if self.stop_from is not None:
            return [stop_and_stand(self.stop_from)]
        return SCENARIOS[name]


def trial(job: tuple[str, int, int, Variant]) -> tuple[str, int, int, wbc.Report]:
    """Run one trial."""
    name, index, seed, variant = job
    scenario = variant.scenarios(name)[index]
    report = run_scenario(
        wbc.load(name),
        scenario,
        seed,
        foot_sensors=variant.foot_sensors,
        friction=variant.friction,
    )
    return name, index, seed, report


def main() -> int:
    """Run the trials, print the table, write the JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--robot",
        action="append",
        choices=sorted(SCENARIOS),
        help="robot to run; may be repeated (default: all)",
    )
    parser.add_argument("--scenario", default="", help="only scenarios whose name contains this")
    parser.add_argument("--seeds", type=int, default=5, help="runs per cell (default: %(default)s)")
    parser.add_argument(
        "--no-foot-sensors",
        dest="foot_sensors",
        action="store_false",
        help="soles without force sensors; joint torques are measured instead",
    )
    parser.add_argument(
        "--friction",
        type=float,
        default=0.8,
        metavar="MU",
        help="between soles and ground (default: %(default)s)",
    )
    parser.add_argument(
        "--stop-from",
        type=float,
        metavar="SPEED",
        help="instead of the scenarios: walk for 4 s at this speed, m/s, stop and stand",
    )
    parser.add_argument(
        "--jobs",
        type=int,
        default=1,
        help="parallel processes; timings are valid with 1 only (default: %(default)s)",
    )
    parser.add_argument("--json", type=Path, help="write all reports to this file")
    parser.add_argument("--readme", type=Path, help="update the table in this file")
    args = parser.parse_args()
    variant = Variant(args.foot_sensors, args.friction, args.stop_from)
    scenarios = {name: variant.scenarios(name) for name in args.robot or SCENARIOS}
    jobs = [
        (name, index, seed, variant)
        for name, own in scenarios.items()
        for index, scenario in enumerate(own)
        if args.scenario in scenario.name
        for seed in range(args.seeds)
    ]
    results: dict[tuple[str, int], list[wbc.Report]] = {}
    start = time.perf_counter()
    with ProcessPoolExecutor(args.jobs) as pool:
        for name, index, seed, report in pool.map(trial, jobs):
            results.setdefault((name, index), []).append(report)
            scenario = scenarios[name][index]
            result = "ok  " if scenario.passed(report) else "FAIL"
            reason = report.fell_why or (report.explanation[:80] if report.qp_failures else "")
            print(
                f"{result} {name:16} {scenario.name:28} seed {seed}  "
                f"{scenario.metric(report):7.2f} {scenario.unit}  {reason}",
                file=sys.stderr,
                flush=True,
            )
    print(table(results, scenarios))
    print(f"\n{len(jobs)} runs in {time.perf_counter() - start:.0f} s")
    if args.readme:
        head, rest = args.readme.read_text(encoding="utf-8").split("<!-- walk:begin -->")
        tail = rest.split("<!-- walk:end -->")[1]
        new = f"{head}<!-- walk:begin -->\n{table(results, scenarios)}\n<!-- walk:end -->{tail}"
        args.readme.write_text(new, encoding="utf-8")
    if args.json:
        rows = [
            {"robot": n, "scenario": scenarios[n][i].name, "seed": s, **asdict(r)}
            for (n, i), reports in results.items()
            for s, r in enumerate(reports)
        ]
        args.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    failed = [
        r for (n, i), reports in results.items() for r in reports if not scenarios[n][i].passed(r)
    ]
    return 1 if failed else 0


def table(
    results: dict[tuple[str, int], list[wbc.Report]], scenarios: dict[str, list[Scenario]]
) -> str:
    """Return a Markdown table with one row per robot and scenario."""
    lines = [
        "| robot | scenario | passed | reached (worst) | cruise, m/s | DCM error, mm rms | "
        "peak torque | beyond joint limits, rad | QP failures | tick, µs (p50 / p99) | "
        "× real time |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for (name, index), reports in results.items():
        scenario = scenarios[name][index]
        passed = sum(scenario.passed(r) for r in reports)

        def median(key: str, of: list[wbc.Report] = reports) -> float:
            return statistics.median(getattr(r, key) for r in of)

        worst = min(scenario.metric(r) for r in reports)
        lines.append(
            f"| {name} | {scenario.name} | {passed}/{len(reports)} | {worst:.2f} {scenario.unit} | "
            f"{median('cruise_speed_m_s'):.2f} | {median('dcm_error_rms_mm'):.1f} | "
            f"{100 * max(r.torque_peak_ratio for r in reports):.0f} % | "
            f"{max(r.joint_limit_excess_rad for r in reports):.1g} | "
            f"{sum(r.qp_failures for r in reports)} | "
            f"{median('tick_p50_us'):.0f} / {median('tick_p99_us'):.0f} | "
            f"{median('real_time_factor'):.1f} |"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
