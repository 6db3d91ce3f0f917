"""The model doctor: each defect is found, named, explained and given a cure."""

from __future__ import annotations

import re

import numpy as np
import pytest
from robottools import CHAPTER, FEET, SIMPLE, changed, codes, element, inertial

import wbc
import wbc.robot
from wbc.command import Status
from wbc.errors import RobotNotFound, WbcError

check = wbc.robot.check_file


def test_a_sound_robot_has_no_findings():
    assert check("simple_humanoid") == []
    assert check(SIMPLE) == []


def test_minimal_tutorial_robot_gets_its_findings():
    findings = check(CHAPTER)
    assert codes(findings) == {
        ("singular-mass-matrix", "right_thigh"),
        ("feet-not-found", "chapter_minimal.urdf"),
    }
    thigh = findings[0]
    assert "right_hip" in thigh.what
    assert "line 58" in thigh.what
    assert "undefined" in thigh.consequence
    assert "<inertial>" in thigh.cure


def test_a_missing_file_is_not_a_finding():
    with pytest.raises(RobotNotFound):
        check("/nowhere.urdf")


KNEE = '<limit lower="0" upper="2.4" effort="200" velocity="12"/>'
BALL = '<sphere radius="0.11"/>'
HEAD = inertial("head")
NECK = element("joint", "neck")
ANCHOR = (
    '<link name="world"/><joint name="bolt" type="{}"><parent link="world"/>'
    '<child link="base_link"/></joint></robot>'
)
SHAPE = '<link name="deco"><visual><geometry><sphere radius="0.1"/></geometry></visual></link>'
FIXED = '<joint name="d" type="fixed"><parent link="torso"/><child link="deco"/></joint></robot>'


def head(old, new):
    """A replacement inside the head's inertial."""
    assert old in HEAD
    return (HEAD, HEAD.replace(old, new))


def neck(old, new):
    """A replacement inside the neck joint."""
    assert old in NECK
    return (NECK, NECK.replace(old, new))


def extra(text):
    """Text put before the end of the file."""
    return ("</robot>", text + "</robot>")


def mesh(address):
    """The head drawn as a mesh."""
    return (BALL, f'<mesh filename="{address}"/>')


MASSLESS = (HEAD, HEAD.replace('"3.2"', '"0"').replace("0.015488", "0"))
DEFECTS = [  # code, subject, severity, replacements
    ("no-inertia", "right_shin", "note", [(inertial("right_shin"), "")]),
    ("no-inertia", "deco", "note", [("</robot>", SHAPE + FIXED)]),
    ("singular-mass-matrix", "head", "error", [(HEAD, "")]),
    ("singular-mass-matrix", "head", "error", [MASSLESS]),
    ("singular-mass-matrix", "head", "error", [head("0.015488", "0")]),
    ("non-physical-inertia", "head", "warning", [head('ixx="0.015488"', 'ixx="0.9"')]),
    ("non-physical-inertia", "head", "warning", [head('ixx="0.015488"', 'ixx="-0.1"')]),
    ("non-physical-inertia", "right_shin", "warning", [('izz="0.002835"', 'izz="0.2"')]),
    ("non-physical-inertia", "right_hand", "note", [('ixx="0.000324"', 'ixx="0.3"')]),
    ("implausible-inertia", "head", "warning", [head("0.015488", "15488")]),
    ("negative-mass", "head", "error", [head('"3.2"', '"-3.2"')]),
    ("unreadable-number", "head", "error", [head('"3.2"', '"heavy"')]),
    ("no-effort-limit", "neck", "warning", [neck('effort="10"', 'effort="0"')]),
    ("no-velocity-limit", "neck", "warning", [neck('velocity="6"', "")]),
    ("no-position-limit", "right_knee", "warning", [(KNEE, "")]),
    ("no-effort-limit", "right_knee", "warning", [(KNEE, "")]),
    ("empty-range", "right_knee", "error", [(KNEE, KNEE.replace('lower="0"', 'lower="3"'))]),
    ("empty-range", "neck", "warning", [neck('lower="-1.57"', 'lower="1.57"')]),
    ("unreadable-number", "neck", "error", [neck('effort="10"', 'effort="ten"')]),
    ("mimic", "neck", "note", [neck("<axis", '<mimic joint="torso_yaw"/><axis')]),
    ("no-floating-base", "bolt", "warning", [("</robot>", ANCHOR.format("fixed"))]),
    ("own-floating-base", "bolt", "note", [("</robot>", ANCHOR.format("floating"))]),
    ("inner-floating-joint", "neck", "error", [neck("revolute", "planar")]),
    ("unknown-joint-type", "neck", "error", [neck("revolute", "ball")]),
    ("duplicate-name", "head", "error", [extra(element("link", "head"))]),
    ("duplicate-name", "neck", "error", [extra(NECK)]),
    ("missing-link", "neck", "error", [neck('child link="head"', 'child link="haed"')]),
    ("disconnected-link", "head", "error", [(NECK, "")]),
    ("loop", "again", "error", [extra(NECK.replace('"neck"', '"again"'))]),
    ("missing-mesh", "head", "warning", [mesh("skull.stl")]),
    ("missing-mesh", "head", "warning", [mesh("package://example-robot-data/skull.stl")]),
    ("broken-shape", "head", "warning", [(BALL, "<sphere/>")]),
    ("broken-shape", "head", "warning", [(BALL, '<ball radius="0.11"/>')]),
    ("broken-shape", "head", "warning", [(BALL, '<sphere radius="-0.11"/>')]),
    ("unresolved-package", "head", "warning", [mesh("package://lost/skull.stl")]),
    (
        *("feet-not-found", "changed.urdf", "error"),
        [
            *((f'{end}="left_foot"', f'{end}="left_boot"') for end in ("link name", "child link")),
            (
                'child link="left_shin"/><origin xyz="0 0 -0.38"',
                'child link="left_shin"/><origin xyz="0 0 -0.2"',
            ),
        ],
    ),
    ("too-weak", "right_knee", "warning", [(KNEE, KNEE.replace("200", "3"))]),
]


@pytest.mark.parametrize(("code", "subject", "severity", "replacements"), DEFECTS)
def test_each_defect_gives_its_finding_with_the_subject(
    tmp_path, code, subject, severity, replacements
):
    findings = check(changed(tmp_path, *replacements))
    found = [f for f in findings if (f.code, f.subject) == (code, subject)]
    assert len(found) == 1, codes(findings)
    assert found[0].severity == severity
    assert found[0].what
    assert found[0].consequence
    assert found[0].cure


@pytest.mark.parametrize(("code", "subject", "severity", "replacements"), DEFECTS)
def test_load_refuses_what_the_doctor_reports_as_an_error(
    tmp_path, code, subject, severity, replacements
):
    """With errors there is no robot; without any there is one, and it is finite."""
    path = changed(tmp_path, *replacements)
    errors = [finding for finding in check(path) if finding.severity == "error"]
    if errors:
        with pytest.raises(WbcError):
            wbc.robot.load(path)
    else:
        robot = wbc.robot.load(path)
        assert np.isfinite(robot.q_nominal).all()
        assert (code, subject) in codes(robot.check())


@pytest.mark.parametrize(
    ("content", "where"),
    [("<robot>\n<link name='a'>\n</robot>", "line 3"), ("<sdf/>", "line 1"), ("", "line 1")],
)
def test_malformed_xml_is_one_finding_with_its_line(tmp_path, content, where):
    path = tmp_path / "bad.urdf"
    path.write_text(content)
    (finding,) = check(path)
    assert (finding.severity, finding.code, finding.subject) == ("error", "unreadable", "bad.urdf")
    assert where in finding.what


def test_all_defects_of_a_file_are_found_at_once_and_the_worst_comes_first(tmp_path):
    path = changed(
        tmp_path,
        (element("joint", "neck"), ""),
        (KNEE, ""),
        ("</robot>", element("link", "left_hand") + "</robot>"),
        ('<sphere radius="0.06"/>', '<mesh filename="gone.stl"/>'),
    )
    findings = check(path)
    assert {code for code, _ in codes(findings)} == {
        "disconnected-link",
        "duplicate-name",
        "no-position-limit",
        "no-effort-limit",
        "no-velocity-limit",
        "missing-mesh",
    }
    ranks = [("error", "warning", "note").index(finding.severity) for finding in findings]
    assert ranks == sorted(ranks)


def test_an_unresolved_package_is_one_finding_and_can_be_given(tmp_path):
    mesh = '<mesh filename="package://lost/{}.stl"/>'
    path = changed(
        tmp_path,
        ('<sphere radius="0.11"/>', mesh.format("skull")),
        ('<cylinder radius="0.06" length="0.28"/>', mesh.format("thigh")),
    )
    (finding,) = check(path)
    assert finding.code == "unresolved-package"
    assert "2 meshes" in finding.what
    assert "right_thigh" in finding.what
    (tmp_path / "elsewhere" / "lost").mkdir(parents=True)
    for name in ("skull", "thigh"):
        (tmp_path / "elsewhere" / "lost" / f"{name}.stl").write_bytes(b"")
    found = check(path, package_dirs=[tmp_path / "elsewhere"])
    assert {code for code, _ in codes(found)} == {"empty-mesh"}


def test_wrongly_stated_feet_are_findings():
    (finding,) = check(SIMPLE, left_foot="left_fot", right_foot="right_foot")
    assert finding.code == "feet-not-found"
    assert "'left_foot'" in finding.cure


def test_a_foot_that_cannot_be_made_flat_is_a_finding(tmp_path):
    """Without ankles a foot whose sole is cut at an angle stays at that angle."""
    old = '<collision><origin xyz="0.04 0 -0.06"/>'
    new = '<collision><origin xyz="0.04 0 -0.06" rpy="0.2 0 0"/>'
    path = changed(tmp_path, (old, new))
    ankles = ("*ankle*", "*hip_roll", "*hip_yaw")
    found = codes(check(path, **FEET, fixed_joints=ankles))
    assert ("sole-not-flat", "left_foot") in found
    assert ("rank-deficient-leg", "left_foot") in found
    # With its ankles the robot levels the foot.
    assert "sole-not-flat" not in {code for code, _ in codes(check(path, **FEET))}


def test_a_stretched_leg_is_a_finding():
    straight = {"left_knee": 0.0, "right_knee": 0.0}
    robot = wbc.robot.load("simple_humanoid", nominal_posture=straight)
    assert ("rank-deficient-leg", "left_foot") in codes(robot.check())


def test_a_posture_beyond_a_limit_is_a_finding():
    robot = wbc.robot.load("simple_humanoid", nominal_posture={"left_elbow": -0.4})
    assert ("posture-beyond-limit", "left_elbow") in codes(robot.check())


def test_exchanged_feet_are_a_finding():
    robot = wbc.robot.load(SIMPLE, left_foot="right_foot", right_foot="left_foot")
    assert ("backward-base", "base_link") in codes(robot.check())


def test_point_feet_are_a_finding():
    robot = wbc.robot.load("bolt", left_foot="FL_FOOT", right_foot="FR_FOOT")
    found = codes(robot.check())
    assert {("point-foot", "FL_FOOT"), ("point-foot", "FR_FOOT")} <= found
    assert ("placeholder-effort-limit", "bolt.urdf") in found
    # Three joints place a point.
    assert "rank-deficient-leg" not in {code for code, _ in found}


def test_values_stated_in_a_data_file_give_no_findings(tmp_path):
    changed(tmp_path, ('effort="10"', 'effort="0"'), name="r.urdf")
    data = tmp_path / "r.toml"
    data.write_text('urdf = "r.urdf"\n[effort_limits]\nneck = 9\n')
    assert check(data) == []


@pytest.mark.parametrize("name", ["talos", "g1", "romeo"])
def test_the_projects_robots_have_no_errors(name):
    assert {finding.severity for finding in wbc.robot.load(name).check()} <= {"warning", "note"}


def test_known_defects_of_icub_are_findings():
    found = codes(wbc.robot.load("icub").check())
    assert ("backward-base", "base_link") in found
    assert len([subject for code, subject in found if code == "non-physical-inertia"]) >= 7


def test_a_finding_prints_as_one_line_with_its_cure():
    for finding in check(CHAPTER):
        text = str(finding)
        assert text.startswith(f"{finding.severity}: {finding.subject}: ")
        assert "\n" not in text
        assert finding.cure in text


def test_a_sole_wider_than_long_is_a_finding():
    """The meshes of iCub are turned unless their up axis is respected."""
    found = codes(wbc.robot.load("icub_reduced", respect_up_axis=False).check())
    assert {("wide-sole", "l_sole"), ("wide-sole", "r_sole")} <= found
    assert "wide-sole" not in {code for code, _ in codes(wbc.robot.load("icub").check())}


@pytest.mark.parametrize("name", ["g1", "simple_humanoid", "alexander_v1.lowerBodyOnly"])
def test_a_robot_without_findings_stands_with_feasible_torques(name):
    robot = wbc.robot.load(name)
    assert robot.check() == []
    assert {fact.name for fact in robot.facts} >= {"left sole", "right sole", "nominal posture"}
    controller = wbc.WholeBodyController(robot)
    controller.add(wbc.ComTask())
    controller.add(wbc.PostureTask(robot))
    controller.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in robot.soles])
    command = controller.step(robot.standing())
    assert command.status is Status.OK
    assert (np.abs(command.tau) <= robot.tau_max).all()


def test_a_range_in_degrees_is_a_finding(tmp_path):
    old = '<limit lower="0" upper="2.4" effort="200" velocity="12"/>'
    path = changed(tmp_path, (old, old.replace('"2.4"', '"143"')))
    assert ("degrees", "right_knee") in codes(check(path, **FEET))


def test_masses_in_grams_are_a_finding(tmp_path):
    text = re.sub(
        r'mass value="([\d.]+)"', lambda m: f'mass value="{1e3 * float(m[1])}"', SIMPLE.read_text()
    )
    path = tmp_path / "grams.urdf"
    path.write_text(text)
    assert "implausible-mass" in {code for code, _ in codes(check(path, **FEET))}


def test_an_ankle_whose_axes_are_exchanged_still_leads_to_the_foot(tmp_path):
    text = SIMPLE.read_text()
    for side in ("left", "right"):
        text = text.replace(f'"{side}_ankle"', f'"{side}_ankle_roll_link"')
        text = text.replace(f'"{side}_foot"', f'"{side}_ankle_pitch_link"')
    path = tmp_path / "h2.urdf"
    path.write_text(text)
    robot = wbc.robot.load(path)
    assert [sole.link for sole in robot.soles] == [
        "left_ankle_pitch_link",
        "right_ankle_pitch_link",
    ]
