"""The options of later sessions of `wbc live`."""

from pathlib import Path

from wbc.cli.model_options import ModelOptions
from wbc.cli.outputs import OutputOptions, RecordingOptions
from wbc.cli.simulation import SimulationOptions
from wbc.teleop import StartSessionCommand

FIRST = SimulationOptions(
    OutputOptions(RecordingOptions(html=Path("out/a.html")), log=Path("a.mcap")),
    ModelOptions(armature=0.05),
    robot="talos",
    gains=Path("gains.toml"),
    solver="quadprog",
)


def test_what_was_stated_about_a_robot_holds_for_that_robot_only():
    other = FIRST.for_session(StartSessionCommand("g1", "tiles", 3), 2)
    assert (other.robot, other.terrain, other.seed) == ("g1", "tiles", 3)
    assert (other.model, other.gains, other.solver) == (ModelOptions(), None, "quadprog")
    same = FIRST.for_session(StartSessionCommand("talos", "ramp", 0), 3)
    assert (same.model, same.gains) == (FIRST.model, FIRST.gains)


def test_files_of_later_sessions_do_not_replace_those_of_the_first():
    outputs = FIRST.for_session(StartSessionCommand("g1", "flat", 0), 2).outputs
    assert outputs.log == Path("a_2.mcap")
    assert outputs.recording.html == Path("out/a_2.html")
    assert outputs.json is None
    assert FIRST.outputs.numbered(1) is FIRST.outputs
