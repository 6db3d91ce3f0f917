"""Keyframe files: what they may say, and where they are wrong when they are."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest
from coretools import robot

import wbc
from wbc.errors import MissingExtra, MotionError
from wbc.ik.objective import PostureObjective
from wbc.ik.posture_ik import PostureIK
from wbc.motions.keyframes import Keyframes
from wbc.motions.keyframing import KeyframeError, read_keyframes
from wbc.motions.keyframing.limits import check_limits
from wbc.motions.keyframing.plan import KeyframePlanner

ROOT = Path(__file__).resolve().parents[2]


def written(folder: Path, text: str, name: str = "frames.csv") -> Path:
    path = folder / name
    path.write_text(text, "utf-8")
    return path


def test_csv_and_yaml_files_give_the_same_plan(tmp_path):
    csv = written(
        tmp_path,
        "# a comment\n"
        "time [s], left_elbow [deg], left_hand.x [cm], left_hand.y [m], left_hand.z [mm]\n"
        "\n"
        "1, 60, 35, 0.25, 1100\n"
        "2.5, 20, , , \n",
    )
    yaml = written(
        tmp_path,
        "units: {angle: deg, length: m}\n"
        "keyframes:\n"
        "  - time: 1.0\n"
        "    joints: {left_elbow: 60}\n"
        "    places: {left_hand: [0.35, 0.25, 1.1]}\n"
        "  - {time: 2.5, joints: {left_elbow: 20}}\n",
        "frames.yaml",
    )
    for frames in (read_keyframes(csv), read_keyframes(yaml)):
        assert [frame.time.number for frame in frames] == [1.0, 2.5]
        elbows = [frame.joints["left_elbow"].number for frame in frames]
        assert elbows == pytest.approx([math.radians(60), math.radians(20)])
        place = [v.number for v in frames[0].places["left_hand"]]
        assert place == pytest.approx([0.35, 0.25, 1.1])
        assert not frames[1].places
    assert read_keyframes(csv)[1].joints["left_elbow"].where.line == 5


@pytest.mark.parametrize(
    ("text", "where", "what"),
    [
        ("", (1, 1), "header line"),
        ("time [s], a [deg]\n", (1, 1), "at least one keyframe"),
        ("a [deg], time [s]\n1, 1\n", (1, 1), "first column"),
        ("time [s], elbow\n1, 2\n", (1, 11), "name and a unit"),
        ("time [h], a [deg]\n1, 2\n", (1, 1), "unit 'h'"),
        ("time [s], a [grad]\n1, 2\n", (1, 11), "unit 'grad' is not one of rad, deg"),
        ("time [s], a [deg], a [rad]\n1, 2, 3\n", (1, 20), "already"),
        ("time [s], hand.x [m], hand.y [m]\n1, 2, 3\n", (1, 11), r"no column 'hand\.z'"),
        ("time [s], a [deg]\n1, 2, 3\n", (2, 7), "3 cells where the header has 2"),
        ("time [s], a [deg]\n1\n", (2, 2), "1 cells"),
        ("time [s], a [deg]\n1, b2\n", (2, 4), "'b2' is not a number"),
        ("time [s], a [deg]\n1, inf\n", (2, 4), "not finite"),
        ("time [s], a [deg]\n, 3\n", (2, 1), "needs its time"),
        ("time [s], a [deg]\n0, 3\n", (2, 1), "stands at 0 s"),
        ("time [s], a [deg]\n2, 3\n2, 4\n", (3, 1), "after 2 s"),
        ("time [s], h.x [m], h.y [m], h.z [m]\n1, 2, , 3\n", (2, 4), "'h' has no y"),
        ("time [s]; a [deg]\n1; 2\n", (1, 1), "separated from the next by a comma"),
        ("time, a [deg]\n1, 2\n", (1, 1), r"must be  time \[s\]"),
        ("time [s]\n1\n", (1, 1), "no column besides the time"),
        ("time [s], a [deg],\n1, 2,\n", (1, 19), "without a name"),
        ("time [s], a [deg]\n1_0, 2\n", (2, 1), "'1_0' is not a number"),
        ("time [s], a [deg]\r\n1, 2\r\n1e9, 3\r\n", (3, 1), "at most 600 s"),
    ],
)
def test_invalid_csv_is_refused_with_line_and_column(tmp_path, text, where, what):
    with pytest.raises(KeyframeError, match=what) as refused:
        read_keyframes(written(tmp_path, text))
    assert str(refused.value).startswith(f"frames.csv:{where[0]}:{where[1]}: ")


@pytest.mark.parametrize(
    ("text", "where", "what"),
    [
        ("keyframes: [\n", (2, 1), "malformed"),
        ("- 1\n", (1, 1), "must be a table"),
        ("frames: []\n", (1, 1), "did you mean 'keyframes'"),
        ("keyframes: 3\n", (1, 12), "must be a list"),
        ("keyframes:\n  - joints: {a: 1}\n", (2, 5), "needs its time"),
        ("keyframes:\n  - time: soon\n", (2, 11), "'soon' is not a number"),
        ("keyframes:\n  - {time: 1, joints: {a: 1}}\n", (2, 27), r"units\.angle is not stated"),
        ("units: {angle: turns}\nkeyframes: [{time: 1}]\n", (1, 16), "unit 'turns'"),
        ("units: {angle: [deg]}\nkeyframes: [{time: 1}]\n", (1, 16), "one of rad, deg is expected"),
        ("units: {angle: deg}\x01\n", (1, 20), "character 0x01 is not allowed"),
        ("keyframes:\n  - {time: 1, time: 2}\n", (2, 15), "'time' exists already"),
        ("keyframes:\n  - {[1]: 2}\n", (2, 6), "table of names and values"),
        ("keyframes:\n\t- time: 1\n", (2, 1), "cannot start any token"),
        ("keyframes:\n  - {time: .nan}\n", (2, 12), "'.nan' is not a number"),
        ("keyframes:\n  - {time: 2}\n  - {time: 1}\n", (3, 12), "after 2 s"),
        (
            "units: {length: m}\nkeyframes:\n  - {time: 1, places: {left_hand: [1, 2]}}\n",
            (3, 35),
            r"\[x, y, z\]",
        ),
    ],
)
def test_invalid_yaml_is_refused_with_line_and_column(tmp_path, text, where, what):
    with pytest.raises(KeyframeError, match=what) as refused:
        read_keyframes(written(tmp_path, text, "frames.yaml"))
    assert str(refused.value).startswith(f"frames.yaml:{where[0]}:{where[1]}: ")


def test_marks_added_by_spreadsheets_are_ignored(tmp_path):
    path = tmp_path / "frames.csv"
    path.write_bytes(b'\xef\xbb\xbf"time [s]","a [deg]"\r\n"1","90"\r\n')
    (frame,) = read_keyframes(path)
    assert frame.time.number == 1.0
    assert frame.joints["a"].number == pytest.approx(math.pi / 2)
    path.write_bytes("time [s], a [deg]\n1, 2 °\n".encode("latin-1"))
    with pytest.raises(KeyframeError, match=r"frames\.csv:2:6: byte 0xb0 is not UTF-8"):
        read_keyframes(path)


def test_unreadable_keyframe_files_are_refused(tmp_path, monkeypatch):
    with pytest.raises(MotionError, match="cannot read"):
        read_keyframes(tmp_path / "none.csv")
    with pytest.raises(MotionError, match=r"must end in \.csv"):
        read_keyframes(written(tmp_path, "", "frames.txt"))
    with pytest.raises(MotionError, match="--file"):
        Keyframes().check(robot("simple_humanoid"))
    monkeypatch.setitem(sys.modules, "yaml", None)
    with pytest.raises(MissingExtra, match=r"pip install 'wbc\[yaml\]'"):
        read_keyframes(written(tmp_path, "keyframes: []", "frames.yml"))


@pytest.mark.parametrize(
    ("text", "where", "what"),
    [
        (
            "time [s], left_elbw [deg]\n1, 20\n",
            (2, 4),
            "no joint 'left_elbw'; did you mean 'left_elbow'",
        ),
        ("time [s], left_elbow [m]\n1, 2\n", (2, 4), "stated as a length"),
        ("time [s], h.x [m], h.y [m], h.z [m]\n1, 2, 2, 2\n", (2, 4), "no hand 'h'"),
        (
            "time [s], left_elbow [deg]\n1, 20\n3, 170\n",
            (3, 4),
            r"position of 'left_elbow' at .* beyond \[0\.00, 2\.50\]",
        ),
        (
            "time [s], left_elbow [deg]\n0.05, 120\n1, 20\n",
            (2, 7),
            "velocity of 'left_elbow'",
        ),
        (
            "time [s], left_hand.x [m], left_hand.y [m], left_hand.z [m]\n2, 1.5, 0, 1\n",
            (2, 4),
            "'left_hand' at .* is out of reach by .* mm: .*(at the limit|is stretched)",
        ),
        ("time [s], left_knee [deg]\n1, 60\n", (2, 4), "lifts or turns a sole"),
        ("time [s], com.x [cm]\n0.5, 12\n", (2, 1), "too far out or too fast"),
        (
            "time [s], left_elbow [deg], left_hand.x [m], left_hand.y [m], left_hand.z [m]\n"
            "1, 20, 0.3, 0.3, 1\n",
            (2, 4),
            "cannot be given while 'left_hand' is led",
        ),
    ],
)
def test_keyframes_beyond_the_robots_limits_are_refused_before_the_start(
    tmp_path, text, where, what
):
    path = written(tmp_path, text)
    with pytest.raises(KeyframeError, match=what) as refused:
        Keyframes(file=str(path)).check(robot("simple_humanoid"))
    assert str(refused.value).startswith(f"frames.csv:{where[0]}:{where[1]}: ")


def test_keyframes_beyond_the_torque_limits_are_refused(tmp_path):
    path = written(tmp_path, "time [s], neck [deg]\n0.45, 80\n1, 0\n")
    Keyframes(file=str(path)).check(robot("simple_humanoid"))
    weak = wbc.load("simple_humanoid")
    weak.model.effortLimit[6 + weak.joint_index("neck")] = 0.5
    with pytest.raises(KeyframeError, match=r"frames\.csv:2:7: torque of 'neck' at .* N·m, beyond"):
        Keyframes(file=str(path)).check(weak)


def test_plan_passes_its_keyframes_from_standing_to_rest(tmp_path):
    one = robot("simple_humanoid")
    path = written(
        tmp_path,
        "time [s], torso_yaw [deg], left_hand.x [m], left_hand.y [m], left_hand.z [m]\n"
        "1.5, 10, 0.3, 0.25, 1.0\n3, -10, 0.2, 0.4, 1.1\n",
    )
    planner = KeyframePlanner(one, read_keyframes(path), "frames.csv")
    plan = planner.plan()
    check_limits(planner, plan)
    ik = PostureIK(one)
    legs = {j - 6 for leg in one.legs for j in leg}
    upper = [j for j in range(one.na) if j not in legs]
    assert plan.posture(0.0)[upper] == pytest.approx(one.q_nominal[7:][upper], abs=0.02)
    yaw = one.joint_index("torso_yaw")
    for time, angle, place in ((1.5, 10, (0.3, 0.25, 1.0)), (3.0, -10, (0.2, 0.4, 1.1))):
        assert plan.posture(time)[yaw] == pytest.approx(math.radians(angle), abs=1e-6)
        assert plan.places["left"](time) == pytest.approx(place)
        q = one.q_nominal.copy()
        q[7:] = plan.posture(time)
        on_soles, miss, _ = ik.place_on_left_sole(q)
        assert miss < 1e-3
        assert ik.frame_position("left_hand", on_soles) == pytest.approx(place, abs=2e-3)
        assert ik.com_and_trunk(on_soles)[0] == pytest.approx(plan.com(time), abs=1e-3)
    assert plan.posture.derivatives(3.0)[1] == pytest.approx(np.zeros(one.na))


def test_posture_of_the_legs_moves_the_com_reference(tmp_path):
    one = robot("simple_humanoid")
    ik = PostureIK(one)
    down = ik.solve(
        PostureObjective(com=np.array([0.0, 0.0, -0.05]), strict_trunk=True, strict_com=True)
    )
    names = [n for n in one.joint_names if "hip_pitch" in n or "knee" in n or "ankle_pitch" in n]
    angles = [down.q[7 + one.joint_index(n)] for n in names]
    head = ", ".join(f"{n} [rad]" for n in names)
    text = f"time [s], {head}\n1.5, {', '.join(f'{a:.9f}' for a in angles)}\n"
    plan = KeyframePlanner(one, read_keyframes(written(tmp_path, text)), "frames.csv").plan()
    assert plan.com(1.5) == pytest.approx([0.0, 0.0, -0.05], abs=1e-3)
    assert plan.pelvis(1.5) == pytest.approx(np.zeros(3), abs=1e-3)


@pytest.mark.parametrize("name", ["greeting.yaml", "robot_dance.csv"])
def test_keyframe_files_of_the_examples_are_valid(name):
    Keyframes(file=str(ROOT / "examples" / "motions" / "keyframes" / name)).check(
        robot("simple_humanoid")
    )
