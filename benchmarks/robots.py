"""Makes any robot stand, squat, walk, turn and take a push from its description: the robots table.

For each robot the model doctor comes first; what cannot work is printed with its reason. The others
stand for two seconds, squat once by 10 % of the leg, walk and turn for 4 s at 60 % of the greatest
velocity that the library derives for them, and take a push of 0.1 s from each side while they
stand, 0.05 √(g h) N·s/kg with the height h of the centre of mass (0.15 N·s/kg for 0.9 m). Robots on
four feet sway, squat and trot, and take eight times that push. Every run
is in MuJoCo with physics at 1 kHz, friction 0.8, the description's torque and joint limits, noisy
sensors and the estimator in the loop. Nothing is stated beyond what the table's last column shows.
Tick times go to the progress lines and the JSON file.

    python benchmarks/robots.py                         # the robots of example-robot-data
    python benchmarks/robots.py ~/urdfs                 # all descriptions below a folder
    python benchmarks/robots.py atlas.urdf=l_foot,r_foot --json out/robots.json
    python benchmarks/robots.py --list benchmarks/public_robots.toml --folder ~/robots
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import json
import math
import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

from shared import quadruped_runs

import wbc
from wbc.errors import WbcError
from wbc.motions import Motion, MotionPlayer
from wbc.motions.squat import Squat
from wbc.robot.doctor import check_robot
from wbc.runtime.report import Report
from wbc.runtime.tick import Tick
from wbc.trials import RunEvaluator

#: The bipeds of example-robot-data.
BIPEDS = (
    "talos_reduced", "talos_full_v2", "g1_29dof_rev_1_0", "g1_29dof_with_hand_rev_1_0",
    "romeo_small", "icub_reduced", "icub", "simple_humanoid", "human",
    "alexander_v1.lowerBodyOnly", "bolt",
)  # fmt: skip
#: Its quadrupeds; the URDFs of all but solo12 state the motors' limits.
QUADRUPEDS = (
    "go2", "go1", "a1", "b1", "laikago", "hyq_no_sensors",
    "anymal_b_simple_description/robots/anymal", "anymal_c_simple_description/urdf/anymal",
    "solo12",
)  # fmt: skip
SOLO_EFFORT, SOLO_ARMATURE = 2.7, 5e-4  # N·m, kg·m²; the URDF of solo12 states no motor of it
DESCRIPTIONS = (".urdf", ".xacro", ".mjcf", ".toml")
SHARE = 0.6  # of the greatest velocity
STANDING, MOVING = 1.0, 4.0  # s
LIMIT_EXCESS = 0.01  # rad; MuJoCo's limits are soft, most for links without rotor inertia
PUSH = 0.05  # times √(g h), N·s/kg
FOUR_FEET = 8.0  # times that push
MARKS = ("<!-- robots:begin -->", "<!-- robots:end -->")
LIST_MARKS = ("<!-- public robots:begin -->", "<!-- public robots:end -->")


@dataclass
class Outcome:
    """One activity of one robot.

    Attributes:
        ok: whether the robot did it without a fall, within its limits.
        why: why not.
        com_mm: error of the centre of mass, mm rms: while it stands or squats against its
            reference in truth, while it walks that of the divergent component.
        swing_mm: error of the foot in the air, mm rms; None if none was.
        torque: largest share of any joint's torque limit.
        tick_us: median time of a controller tick, µs.
        text: what it achieved.
    """

    ok: bool
    why: str = ""
    com_mm: float | None = None
    swing_mm: float | None = None
    torque: float = 0.0
    tick_us: float = 0.0
    text: str = ""


@dataclass
class Row:
    """One robot.

    Attributes:
        name: of the robot.
        size: joints, mass and soles.
        feet: number of feet.
        stated: what had to be stated by hand.
        refused: why it cannot walk, or not even be loaded; else empty.
        defects: errors and warnings of the doctor.
        outcomes: by activity.
    """

    name: str
    size: str = ""
    feet: int = 2
    stated: str = ""
    refused: str = ""
    defects: list[str] = field(default_factory=list)
    outcomes: dict[str, Outcome] = field(default_factory=dict)


class SwingError:
    """An observer of how far the foot in the air is from its reference."""

    quantities = ()

    def begin(self, controller: Any, plant: Any) -> None:
        """See `wbc.runtime.protocols.Observer`."""
        self._walker: wbc.Walker = controller.walker
        self._square_sum, self._ticks = 0.0, 0

    def observe(self, tick: Tick) -> None:
        """See `wbc.runtime.protocols.Observer`."""
        state = self._walker.gait_state
        if state.swing is None or tick.command.status is not wbc.Status.OK:
            return
        foot = state.feet.of(state.swing_side)
        x, y, z = state.swing.motion.position
        self._square_sum += abs(foot.point - complex(x, y)) ** 2 + (foot.height - z) ** 2
        self._ticks += 1

    def end(self, report: Report) -> None:
        """See `wbc.runtime.protocols.Observer`."""

    @property
    def rms_mm(self) -> float | None:
        """Root of the mean square over the ticks with a foot in the air, mm."""
        return 1e3 * math.sqrt(self._square_sum / self._ticks) if self._ticks else None


def simulate(
    robot: wbc.Robot,
    duration: float,
    motions: tuple[Motion, ...] = (),
    before_tick: Callable[[float, MotionPlayer, Any], None] = lambda *_: None,
) -> tuple[Report, Outcome]:
    """Run a motion player in closed loop; return the report and what can be read from it."""
    player = MotionPlayer(robot, motions=motions)
    evaluator, swing = RunEvaluator(), SwingError()
    from wbc.sim import Mujoco

    with Mujoco(robot, dt=player.dt, seed=0) as plant:
        report = wbc.run(
            player,
            plant,
            duration,
            observers=[evaluator, swing],
            before_tick=lambda t: before_tick(t, player, plant),
            on_falling=lambda _: None,
        )
    report = evaluator.amend(report)
    walked = report.steps > 0
    com = report.dcm_error_rms_mm if walked else report.com_error_rms_mm
    return report, outcome_of(report, com, swing.rms_mm if walked else None)


def outcome_of(report: Report, com_mm: float | None, swing_mm: float | None) -> Outcome:
    """Return what a report says of an activity, with the errors in it."""
    why = report.fell_why
    if not why and report.aborted_motions:
        why = "; ".join(report.notes)
    if not why and report.qp_failures:
        why = report.explanation
    excess = report.joint_limit_excess_rad
    if not why and excess > LIMIT_EXCESS:
        why = f"a joint {excess:.3f} rad beyond its limit"
    return Outcome(
        not why,
        why,
        com_mm,
        swing_mm,
        report.torque_peak_ratio,
        report.tick_p50_us,
        f"joint {excess:.3f} rad beyond its limit" if excess > 1e-3 else "",
    )


def stand(robot: wbc.Robot) -> Outcome:
    """Stand for two seconds."""
    return simulate(robot, 2.0)[1]


def squat(robot: wbc.Robot) -> Outcome:
    """Squat once."""
    motion = Squat(times=1)
    return simulate(robot, 1.0 / motion.frequency + 2.5, (motion,))[1]


def move(robot: wbc.Robot, turning: bool) -> Outcome:
    """Walk forward, or turn in place, and stop."""
    limits = MotionPlayer(robot).walker.gait.max_velocity
    wanted = SHARE * (limits.turn if turning else limits.forward)
    velocity = (0.0, 0.0, wanted) if turning else (wanted, 0.0, 0.0)

    def command(now: float, player: MotionPlayer, _: Any) -> None:
        player.velocity = velocity if STANDING <= now < STANDING + MOVING else (0.0, 0.0, 0.0)

    if not wanted:
        return Outcome(False, "no joint turns the robot on the foot that stands")
    report, outcome = simulate(robot, STANDING + MOVING + 2.0, before_tick=command)
    return judge_speed(report, outcome, wanted, turning)


def judge_speed(report: Report, outcome: Outcome, wanted: float, turning: bool) -> Outcome:
    """Return the outcome of walking or turning at a velocity: half of it is little enough."""
    got = report.turned_rad if turning else report.displacement_m[0]
    reached = f"{got / MOVING:.2f} {'rad/s' if turning else 'm/s'}"
    outcome.text = ", ".join(filter(None, (reached, outcome.text)))
    if outcome.ok and got < 0.5 * wanted * MOVING:
        outcome.ok, outcome.why = False, f"{reached} instead of {wanted:.2f}"
    return outcome


def move_on_four(robot: wbc.Robot, turning: bool) -> Outcome:
    """Trot forward, or turn in place, and stop."""
    limits = wbc.QuadrupedWalker(robot).gait.max_velocity
    wanted = SHARE * (limits.turn if turning else limits.forward)
    velocity = (0.0, 0.0, wanted) if turning else (wanted, 0.0, 0.0)

    def command(now: float, walker: wbc.QuadrupedWalker, _: Any) -> None:
        walker.velocity = velocity if STANDING <= now < STANDING + MOVING else (0.0, 0.0, 0.0)

    report = quadruped_runs.simulate(robot, STANDING + MOVING + 2.0, command)[0]
    outcome = outcome_of(report, report.dcm_error_rms_mm, None)
    return judge_speed(report, outcome, wanted, turning)


def on_four(run: tuple[Report, float]) -> Outcome:
    """Return the outcome of a run of a robot that stands on four feet."""
    return outcome_of(run[0], run[1], None)


def push(robot: wbc.Robot) -> Outcome:
    """Take a push from each of four sides."""
    size = PUSH * math.sqrt(robot.gravity * robot.com_height)
    size *= FOUR_FEET if robot.is_quadruped else 1.0
    failed, worst = [], Outcome(True)
    directions = {"forward": (1, 0), "back": (-1, 0), "left": (0, 1), "right": (0, -1)}
    for name, (x, y) in directions.items():
        impulse = size * robot.mass * np.array([x, y, 0.0])

        def hit(now: float, _: Any, plant: Any, impulse: np.ndarray = impulse) -> None:
            if abs(now - 0.5) < 0.5 * plant.dt:
                plant.push(impulse)

        if robot.is_quadruped:
            outcome = on_four(quadruped_runs.simulate(robot, 3.0, hit))
        else:
            outcome = simulate(robot, 3.0, before_tick=hit)[1]
        worst.torque = max(worst.torque, outcome.torque)
        failed += [] if outcome.ok else [f"{name}: {outcome.why}"]
    worst.ok, worst.why = not failed, "; ".join(failed)
    worst.text = f"{4 - len(failed)}/4 at {size:.2f}"
    return worst


ACTIVITIES: dict[str, Callable[[wbc.Robot], Outcome]] = {
    "stand": stand,
    "squat": squat,
    "walk": lambda robot: move(robot, turning=False),
    "turn": lambda robot: move(robot, turning=True),
    "push": push,
}
#: Those of a robot on four feet.
ACTIVITIES_ON_FOUR: dict[str, Callable[[wbc.Robot], Outcome]] = {
    "stand": lambda robot: on_four(quadruped_runs.simulate(robot, 2.0)),
    "sway": lambda robot: on_four(quadruped_runs.sway_or_squat(robot, axis=1)),
    "squat": lambda robot: on_four(quadruped_runs.sway_or_squat(robot, axis=2)),
    "walk": lambda robot: move_on_four(robot, turning=False),
    "turn": lambda robot: move_on_four(robot, turning=True),
    "push": push,
}


@dataclass(frozen=True)
class Entry:
    """A robot to measure.

    Attributes:
        name: name in the table.
        file: what `wbc.load` takes: a name or a path.
        arguments: what else it takes.
    """

    name: str
    file: str
    arguments: dict[str, Any] = field(default_factory=dict)

    @property
    def stated(self) -> str:
        """What is stated about the robot, for the table."""
        return ", ".join(
            key.replace("_", " ") if isinstance(value, dict) else f"{key} {value}"
            for key, value in self.arguments.items()
        )


def measure(entry: Entry, only: tuple[str, ...], known: dict[str, Outcome]) -> Row:
    """Load a robot and let it do everything but what is known, or say why it cannot."""
    row = Row(entry.name, stated=entry.stated)
    row.outcomes.update(known)
    try:
        robot = wbc.load(entry.file, **entry.arguments)
        findings = [f for f in check_robot(robot) if f.severity != "note"]
        row.defects = [str(f) for f in findings]
        facts = [f.name for f in robot.facts if f.origin == "stated" and not f.name.endswith("t")]
        stated = [name for name in facts if name not in entry.arguments]
        row.stated = ", ".join(filter(None, [entry.stated, *stated]))
        sole = robot.soles[0]
        row.feet = len(robot.soles)
        row.size = f"{robot.na} joints, {robot.mass:.3g} kg, soles {sole.size_text}"
        errors = [f for f in findings if f.severity == "error"]
        if errors:
            row.refused = f"{errors[0].subject}: {errors[0].what}"
            return row
    except WbcError as error:
        row.refused = str(error).removeprefix(f"{entry.file}: ")
        return row
    activities = ACTIVITIES_ON_FOUR if robot.is_quadruped else ACTIVITIES
    for name, activity in activities.items():
        if name in known or (only and name not in only):
            continue
        try:
            row.outcomes[name] = activity(robot)
        except WbcError as error:
            row.outcomes[name] = Outcome(False, f"refused: {error}")
        done = row.outcomes[name]
        tick = f"tick {done.tick_us:.0f} µs" if done.tick_us else ""
        print(f"{row.name:28} {name:6} {cell(done)}  {tick}", file=sys.stderr, flush=True)
    return row


def cell(outcome: Outcome) -> str:
    """Return an outcome as the text of a cell."""
    figures = [outcome.text] if outcome.text else []
    if outcome.com_mm is not None:
        figures.append(f"{outcome.com_mm:.1f} mm")
    if outcome.swing_mm is not None:
        figures.append(f"foot {outcome.swing_mm:.1f} mm")
    why = " ".join(outcome.why.split()).partition("; ")[0]  # without the cure
    return ", ".join(figures) or "yes" if outcome.ok else f"no: {why}"


def table(rows: list[Row]) -> str:
    """Return Markdown tables with one line per robot: on two feet, and on four."""
    kinds = ((2, ACTIVITIES), (4, ACTIVITIES_ON_FOUR))
    of_kinds = (([row for row in rows if row.feet == feet], names) for feet, names in kinds)
    return "\n\n".join(table_of(part, tuple(names)) for part, names in of_kinds if part)


def table_of(rows: list[Row], activities: tuple[str, ...]) -> str:
    """Return a Markdown table of robots that have the same activities."""
    ran_somewhere = [a for a in activities if any(a in row.outcomes for row in rows)]
    head = ("robot", "size", *ran_somewhere, "torque", "stated")
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
    for row in rows:
        outcomes = [row.outcomes.get(name) for name in ran_somewhere]
        ran = [o for o in outcomes if o is not None]
        cells = [cell(o) if o else "" for o in outcomes]
        if row.refused:
            cells = [f"refused: {row.refused.partition('; ')[0]}", *[""] * (len(cells) - 1)]
        torque = f"{100.0 * max(o.torque for o in ran):.0f} %" if ran else ""
        stated = row.stated or "nothing"
        lines.append(f"| {row.name} | {row.size} | {' | '.join(cells)} | {torque} | {stated} |")
    return "\n".join(lines)


def entries_of(where: str) -> list[Entry]:
    """Return the robots that an argument means: itself, or all descriptions below a folder."""
    folder = Path(where).expanduser()
    if folder.is_dir():
        paths = sorted(path for path in folder.rglob("*") if path.suffix in DESCRIPTIONS)
        return [Entry(path.stem, str(path)) for path in paths]
    if where == "solo12":
        return [solo12()]
    file, _, feet = where.partition("=")
    arguments = dict(zip(("left_foot", "right_foot"), feet.split(","), strict=True)) if feet else {}
    name = Path(file).stem if Path(file).suffix in DESCRIPTIONS else file.partition("/")[0]
    return [Entry(name, file, arguments)]


def solo12() -> Entry:
    """Return solo12 with the motors that it has."""
    joints = [f"{leg}_{j}" for leg in ("FL", "FR", "HL", "HR") for j in ("HAA", "HFE", "KFE")]
    limits = dict.fromkeys(joints, SOLO_EFFORT)
    return Entry("solo12", "solo12", {"effort_limits": limits, "armature": SOLO_ARMATURE})


def entries_of_list(path: Path, folder: Path) -> list[Entry]:
    """Return the robots of a list whose repositories are below a folder; report what is missing.

    Args:
        path: TOML file with a table per repository (`owner/name`): names of robots with their
            files, or tables with `file` and what `wbc.load` takes besides.
        folder: folder with the repositories, each in a folder of its name.
    """
    entries = []
    for repository, robots in tomllib.loads(path.read_text(encoding="utf-8")).items():
        root = folder.expanduser() / repository.rpartition("/")[2]
        for name, value in robots.items():
            stated = dict(value) if isinstance(value, dict) else {"file": value}
            file = root / stated.pop("file")
            if file.is_file():
                entries.append(Entry(name, str(file), stated))
            else:
                print(f"{name}: there is no {file} (clone {repository})", file=sys.stderr)
    return entries


def write(path: Path, rows: list[Row]) -> None:
    """Write all figures to a JSON file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps([asdict(row) for row in rows], indent=1) + "\n", encoding="utf-8")


def read_rows(path: Path | None) -> dict[str, Row]:
    """Return the robots that a JSON file holds, by name."""
    if path is None or not path.is_file():
        return {}
    rows = [Row(**row) for row in json.loads(path.read_text(encoding="utf-8"))]
    for row in rows:
        row.outcomes = {name: Outcome(**vars_) for name, vars_ in row.outcomes.items()}
    return {row.name: row for row in rows}


def main() -> int:
    """Run everything, print the table, write the JSON file."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "robots",
        nargs="*",
        metavar="ROBOT[=LEFT,RIGHT]",
        help="name, description or folder, with the links of the feet where names do not tell "
        "(default: those of example-robot-data)",
    )
    parser.add_argument("--list", type=Path, help="file that lists robots by repository")
    parser.add_argument(
        "--folder", type=Path, default=Path(), help="folder with the repositories of the list"
    )
    parser.add_argument("--only", action="append", choices=tuple(ACTIVITIES_ON_FOUR), default=[])
    parser.add_argument("--json", type=Path, help="write all figures to this file")
    parser.add_argument(
        "--resume", action="store_true", help="take what the JSON file holds already from there"
    )
    parser.add_argument("--readme", type=Path, help="update the table in this file")
    args = parser.parse_args()
    warnings.simplefilter("ignore")
    begun = time.perf_counter()
    named = args.robots or ([] if args.list else (*BIPEDS, *QUADRUPEDS))
    robots = [entry for where in named for entry in entries_of(where)]
    if args.list:
        robots += entries_of_list(args.list, args.folder)
    before = read_rows(args.json) if args.resume else {}
    rows: list[Row] = []
    for entry in robots:
        known = before.pop(entry.name, Row(entry.name)).outcomes
        rows.append(measure(entry, tuple(args.only), known))
        if args.json:
            write(args.json, [*rows, *before.values()])
    text = table(rows)
    print(text)
    done = sum(all(o.ok for o in row.outcomes.values()) and not row.refused for row in rows)
    print(f"\n{done} of {len(rows)} do everything; {time.perf_counter() - begun:.0f} s")
    if args.readme:
        begin, end = LIST_MARKS if args.list else MARKS
        head, rest = args.readme.read_text(encoding="utf-8").split(begin)
        tail = rest.split(end)[1]
        args.readme.write_text(f"{head}{begin}\n{text}\n{end}{tail}", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
