"""Robots with servos, and a G1 over its low-level interface: walks, faults, and real time on DDS.

python benchmarks/hardware.py servos      Talos and simple_humanoid as position-controlled robots
python benchmarks/hardware.py latency     a G1 with latency and lost messages, in lockstep
python benchmarks/hardware.py faults      time from each fault to damping, in lockstep
python benchmarks/hardware.py real-time   a G1 in another process over DDS on the loopback
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import itertools
import json
import signal
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterable
from pathlib import Path
from time import perf_counter
from typing import Any, TypeVar

import numpy as np
from shared.hardware_faults import Row, fault_rows
from shared.machine_pauses import MachinePauses

import wbc
from wbc.estimation import LatencyCompensation
from wbc.gait import VelocityLimits
from wbc.geometry.planar import Placement
from wbc.hardware import HardwareError, SafeHardware, UnitreeG1
from wbc.hardware.unitree.connect import connect
from wbc.hardware.unitree.lockstep import Disturbance, LockstepTransport, undisturbed
from wbc.hardware.unitree.stand_in import PERIOD, G1StandIn
from wbc.motions import MotionPlayer, Squat, Wave
from wbc.runtime.loop import RunComplete
from wbc.runtime.real_time import DEFAULT_PRIORITY, RealTime, real_time_thread
from wbc.runtime.report import Report
from wbc.sim import JointServos, Mujoco
from wbc.walking.waypoint_follower import WaypointFollower

Case = TypeVar("Case")
_MOTIONS = (Wave(), Squat())
_STAND, _STOP = 2.0, 3.0  # s at the beginning and the end of a walk


def _walk(plant: Any, speed: float, distance: float, dt: float, **options: Any) -> Report:
    """Walk a distance (m) and stop."""
    walker = wbc.Walker(plant.robot, dt)
    end = _STAND + distance / speed

    def command(time: float) -> None:
        walker.velocity = (speed if _STAND <= time < end else 0.0, 0.0, 0.0)

    return wbc.run(walker, plant, end + _STOP, before_tick=command, **options)


def _row(what: str, seed: int, report: Report) -> Row:
    return {
        "what": what,
        "seed": seed,
        "survived": report.survived,
        "forward_m": round(report.displacement_m[0], 2),
        "steps": report.steps,
        "dcm_error_mm": round(report.dcm_error_rms_mm or 0.0, 1),
        "end": report.fell_why,
    }


def _walk_to(plant: Any, speed: float, distance: float, dt: float) -> Report:
    """Walk to a place straight ahead, by the estimator's odometry, and stop."""
    walker = wbc.Walker(plant.robot, dt)
    follower = WaypointFollower(VelocityLimits(speed, 0.1, 0.1, 0.2))
    waypoint = Placement(complex(walker.feet.middle.real + distance, 0.0), 0.0)
    arrived = 0.0

    def command(time: float) -> None:
        nonlocal arrived
        if time < _STAND:
            return
        pose = Placement(walker.feet.middle, walker.heading)
        walker.velocity = follower.velocity(waypoint, pose)
        arrived = 0.0 if walker.velocity != (0.0, 0.0, 0.0) else arrived or time
        if arrived and time > arrived + _STOP:
            raise RunComplete

    limit = _STAND + 1.5 * distance / speed + _STOP
    return wbc.run(walker, plant, limit, before_tick=command)


def servos(options: argparse.Namespace) -> list[Row]:
    """Walk as position-controlled robots: 2 and 4 ms of delay, friction, backlash of 0.5°."""
    rows = []
    for name in ("talos", "simple_humanoid"):
        robot = wbc.load(name)
        for dt, latency, friction in ((0.002, 0.002, 0.03), (0.004, 0.004, 0.05)):
            for seed in _seeds(options):
                plant = Mujoco(
                    robot, dt=dt, latency=latency, seed=seed, servos=JointServos(friction=friction)
                )
                what = (
                    f"{name}, {1.0 / dt:.0f} Hz, delay {1e3 * latency:g} ms, "
                    f"friction {100.0 * friction:g} %"
                )
                report = _walk_to(plant, 0.3, options.distance, dt)
                rows.append(_row(what, seed, report) | {"duration_s": round(report.duration_s, 1)})
    return rows


def _started(
    seed: int = 0, latency: float = 0.0, disturb: Disturbance = undisturbed
) -> tuple[G1StandIn, LockstepTransport, SafeHardware]:
    stand_in = G1StandIn(seed=seed, latency=latency)
    transport = LockstepTransport(stand_in)
    plant = SafeHardware(UnitreeG1(stand_in.robot, transport), on_transition=lambda change: None)
    plant.start()
    transport.on_state = transport.on_command = disturb
    return stand_in, transport, plant


def latency(options: argparse.Namespace) -> list[Row]:
    """Walk with latency, messages lost on the wire, and the state as read or predicted."""
    rows = []
    cases = [(0.0, 0.0), (0.008, 0.05), (0.018, 0.05), (0.028, 0.05)]
    for (delay, loss), state, seed in _each(cases, options):
        random = np.random.default_rng(seed)

        def lossy(
            time: float, data: bytes, random: Any = random, loss: float = loss
        ) -> list[bytes]:
            return [] if random.random() < loss else [data]

        _, _, plant = _started(seed, delay, lossy)
        estimator = None
        if state == "predicted":
            estimator = LatencyCompensation(
                wbc.Estimator(plant.robot, PERIOD), plant.robot, PERIOD,
                latency=lambda p=plant: p.latency.beyond_ideal,
            )  # fmt: skip
        report = _walk(plant, 0.35, options.distance, PERIOD, estimator=estimator)
        measured = plant.latency.seconds or 0.0
        what = f"g1, servos, {1e3 * delay + 2.0:.0f} ms, {100.0 * loss:g} % lost, state {state}"
        lost = {"measured_latency_ms": round(1e3 * measured, 1), "states_lost": plant.lost}
        rows.append(_row(what, seed, report) | lost)
    robot = wbc.load("g1")
    for delay, state, seed in _each((0.0, 0.01, 0.02, 0.03), options):
        torque = Mujoco(robot, dt=PERIOD, latency=delay, seed=seed)
        estimator = None
        if state == "predicted":
            estimator = LatencyCompensation(
                wbc.Estimator(robot, PERIOD), robot, PERIOD, latency=delay
            )
        report = _walk(torque, 0.35, options.distance, PERIOD, estimator=estimator)
        what = f"g1, torques, {1e3 * delay + 2.0:.0f} ms, state {state}"
        rows.append(_row(what, seed, report))
    return rows


def _each(cases: Iterable[Case], options: argparse.Namespace) -> Iterable[tuple[Case, str, int]]:
    return itertools.product(cases, ("as read", "predicted"), _seeds(options))


def _seeds(options: argparse.Namespace) -> range:
    return range(options.first_seed, options.first_seed + options.seeds)


def _steal_time() -> float:
    """Return the time that the host has taken from this virtual machine so far, s."""
    fields = Path("/proc/stat").read_text("ascii").split("\n", 1)[0].split()
    return int(fields[8]) / os.sysconf("SC_CLK_TCK")


def faults(options: argparse.Namespace) -> list[Row]:
    """Inject faults: time to their detection, from there to damping, and the final state."""
    return fault_rows()


def _session(distance: float) -> list[tuple[float, Callable[[MotionPlayer], object]]]:
    """What the robot of `real_time` is told, by the time, s: the robot stands first and last."""
    walked = 60.0 + distance / 0.35
    return [
        (60.0, lambda player: setattr(player, "velocity", (0.35, 0.0, 0.0))),
        (walked, lambda player: setattr(player, "velocity", (0.0, 0.0, 0.3))),
        (walked + 6.0, lambda player: setattr(player, "velocity", (0.0, 0.0, 0.0))),
        (walked + 9.0, lambda player: player.play(*_MOTIONS)),
        (walked + 26.0, lambda player: None),
    ]


def real_time(options: argparse.Namespace) -> list[Row]:
    """Stand for 60 s, walk, turn, stop, wave and squat, with a push while standing and walking.

    The G1 is in another process behind DDS. Both sides ask for real-time priority, also where they
    are niced.
    """
    robot = wbc.load("g1")
    player = MotionPlayer(robot, motions=[*_MOTIONS])
    player.velocity = (0.1, 0.0, 0.0)
    wbc.run(player, Mujoco(robot, foot_sensors=False), 12.0)  # loads what the first ticks need
    impulse = 0.2 * robot.mass
    rows = []
    for seed in _seeds(options):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "robot.json"
            # From when the gantry has let go, half a second after the controller has taken over.
            pushes = f"30 0 {impulse} 0", f"70 {impulse} 0 0"
            process = subprocess.Popen(
                [sys.executable, "-m", "wbc", "robot", "unitree-g1", "--seed", str(seed),
                 "--json", str(path), *(a for push in pushes for a in ("--push", push))],
                stdout=subprocess.PIPE, text=True,
            )  # fmt: skip
            try:
                assert process.stdout is not None
                process.stdout.readline()
                with MachinePauses() as pauses:
                    rows.append(_real_time_row(player, seed, options.distance))
            except HardwareError as refusal:
                rows.append({"what": "start", "seed": seed, "survived": False, "end": str(refusal)})
            finally:
                process.send_signal(signal.SIGINT)
                process.communicate(timeout=30.0)
            simulated = json.loads(path.read_text())
            rows[-1]["robot_lateness_p99_us"] = round(simulated["lateness_p99_us"], 1)
            rows[-1]["machine_pause_ms"] = round(1e3 * pauses.longest, 1)
            rows[-1]["robot_said"] = "; ".join(
                f"{at:.1f} s {what}" for at, what in simulated["changes"]
            )
            print(rows[-1], file=sys.stderr, flush=True)
    return rows


def _real_time_row(player: MotionPlayer, seed: int, distance: float) -> Row:
    orders = _session(distance)
    duration, stolen = orders[-1][0], _steal_time()
    begun, late = np.zeros((2, round(1.01 * duration / PERIOD)))
    ticks = 0
    player.velocity = (0.0, 0.0, 0.0)

    def command(time: float) -> None:
        nonlocal ticks
        begun[ticks], late[ticks] = perf_counter(), plant.lateness
        ticks += 1
        while orders and time >= orders[0][0]:
            orders.pop(0)[1](player)

    with (
        SafeHardware(connect("lo", player.robot)) as plant,
        real_time_thread(RealTime(DEFAULT_PRIORITY)) as granted,
    ):
        report = wbc.run(player, plant, duration, before_tick=command)
        connection, latency = plant.connection, plant.latency.seconds
    periods = np.diff(begun[1:ticks])  # the first one has the start in it
    period = np.percentile(periods, (50, 99, 100)) if ticks > 2 else np.zeros(3)
    return _row("g1 over DDS in real time", seed, report) | {
        "aborted_motions": report.aborted_motions,
        "duration_s": round(report.duration_s, 1),
        "tick_us": [round(getattr(report, f"tick_{q}_us")) for q in ("p50", "p99", "max")],
        "period_us": [round(1e6 * p) for p in period],
        "latency_ms": None if latency is None else round(1e3 * latency, 1),
        "lateness_us": [round(1e6 * d) for d in np.percentile(late[1:ticks], (50, 99, 99.9))],
        "max_lateness_ms": round(1e3 * plant.max_lateness, 2),
        "latest_at_s": round(PERIOD * int(np.argmax(late)), 1),
        "received": connection.received,
        "lost": plant.lost,
        "corrupt": connection.corrupt,
        "reordered": connection.reordered,
        "steal_time_s": round(_steal_time() - stolen, 2),
        "conditions": granted.describe(),
    }


_PARTS = {
    "servos": servos,
    "latency": latency,
    "faults": faults,
    "real-time": real_time,
}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("part", choices=_PARTS, help="what to measure")
    parser.add_argument("--seeds", type=int, default=5, help="number of seeds of sensor noise")
    parser.add_argument("--first-seed", type=int, default=0, help="the first one")
    parser.add_argument("--distance", type=float, default=10.0, help="m to walk")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    warnings.simplefilter("ignore", wbc.VelocityClamped)
    rows = _PARTS[options.part](options)
    for row in rows:
        print("  ".join(f"{key} {value}" for key, value in row.items() if value != ""))
    if options.json is not None:
        options.json.write_text(json.dumps(rows, indent=2) + "\n", "utf-8")


if __name__ == "__main__":
    main()
