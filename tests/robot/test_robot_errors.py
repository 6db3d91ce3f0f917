"""Bad input to `load`: a named error with the place and the cure, never a NaN or a C++ trace."""

from __future__ import annotations

import pytest
from robottools import CHAPTER, FEET, changed, codes, element, inertial

import wbc
import wbc.robot
from wbc.errors import GaitError, RobotDescriptionError, RobotNotFound, WbcError


def load(path, **stated):
    return wbc.robot.load(path, **{**FEET, **stated})


@pytest.mark.parametrize(
    ("wrong", "near"), [("tolos", "talos"), ("G1", "g1"), ("icub_redced", "icub_reduced")]
)
def test_unknown_robot_suggests_near_names(wrong, near):
    with pytest.raises(RobotNotFound, match=f"no robot '{wrong}'.*'{near}'"):
        wbc.robot.load(wrong)


def test_missing_file_is_not_found():
    with pytest.raises(RobotNotFound, match=r"no file .*nowhere\.urdf"):
        wbc.robot.load("/nowhere.urdf")


def test_a_folder_as_robot_file_is_refused(tmp_path):
    with pytest.raises(RobotDescriptionError, match="folder"):
        wbc.robot.load(tmp_path)


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        ("", "line 1: the XML is malformed"),
        ("<robot>\n<link name='a'>\n</robot>", "line 3: the XML is malformed"),
        ("<robot name='r'>\n<link/>\n</robot>", "line 2: a <link> has no name"),
        ("<robot name='r'></robot>", "no <link>"),
        ("<sdf version='1.6'/>", "the root element is <sdf>"),
        (
            "<robot name='r'><link name='a'/>\n<joint name='j' type='fixed'>"
            "<parent link='a'/></joint></robot>",
            "line 2: joint 'j' has no <child",
        ),
        ("\x00\x01binary", "malformed"),
    ],
)
def test_a_malformed_file_names_its_line(tmp_path, content, complaint):
    path = tmp_path / "bad.urdf"
    path.write_text(content)
    with pytest.raises(RobotDescriptionError, match=complaint) as caught:
        wbc.robot.load(path)
    assert "bad.urdf" in str(caught.value)


def test_a_latin_1_file_is_refused_as_malformed(tmp_path):
    path = tmp_path / "latin.urdf"
    path.write_bytes("<robot name='é'/>".encode("latin-1"))
    with pytest.raises(RobotDescriptionError, match="malformed"):
        wbc.robot.load(path)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>', "axis of length zero"),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 1"/>', 'xyz="0 1"; it must hold 3 finite numbers'),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 nan 0"/>', "3 finite numbers"),
        ('effort="200"', 'effort="strong"', 'effort="strong"'),
        ('lower="0" upper="2.4"', 'lower="2.4" upper="0"', "lower limit 2.4 above its upper 0"),
        ('<mass value="4.5"/>', '<mass value="-4.5"/>', "'right_thigh' has the mass -4.5 kg"),
        ('<mass value="4.5"/>', '<mass value="inf"/>', 'value="inf"'),
        ('<child link="left_foot"/>', '<child link="leftfoot"/>', "names the link 'leftfoot'"),
        ('<link name="left_shin">', '<link name="right_shin">', "a second link 'right_shin'"),
        ('<joint name="left_knee"', '<joint name="right_knee"', "a second joint 'right_knee'"),
        ('"left_knee" type="revolute"', '"left_knee" type="hinge"', "the type 'hinge'"),
        ('"neck" type="revolute"', '"neck" type="floating"', "only the base may float"),
    ],
)
def test_an_invalid_urdf_element_is_refused_by_name(tmp_path, old, new, complaint):
    with pytest.raises(RobotDescriptionError, match=complaint):
        load(changed(tmp_path, (old, new)))


def test_an_unconnected_link_is_refused_by_name(tmp_path):
    path = changed(tmp_path, (element("joint", "neck"), ""))
    with pytest.raises(RobotDescriptionError, match=r"'head' are no joint's child"):
        load(path)


def test_a_loop_is_refused(tmp_path):
    joint = element("joint", "neck").replace('"neck"', '"again"')
    path = changed(tmp_path, ("</robot>", joint + "</robot>"))
    with pytest.raises(RobotDescriptionError, match="second joint into the link 'head'"):
        load(path)


def test_a_loop_apart_from_the_base_is_refused(tmp_path):
    joint = element("joint", "left_knee")
    path = changed(
        tmp_path,
        (element("joint", "left_hip_pitch"), ""),
        (
            "</robot>",
            joint.replace('"left_knee"', '"round"')
            .replace("left_thigh", "left_foot")
            .replace('child link="left_shin"', 'child link="left_thigh"')
            + "</robot>",
        ),
    )
    with pytest.raises(RobotDescriptionError, match=r"'left_thigh'.* form a loop"):
        load(path)


def test_massless_end_links_are_refused_by_name(tmp_path):
    path = changed(tmp_path, (inertial("head"), ""))
    with pytest.raises(RobotDescriptionError, match=r"'neck' \(moves link 'head'\).*<inertial>"):
        load(path)
    assert load(path, fixed_joints=["neck"]).na == 19


def test_a_massless_base_below_a_heavy_torso_is_accepted(tmp_path):
    robot = load(changed(tmp_path, (inertial("base_link"), "")))
    assert robot.mass == pytest.approx(54.6 - 7, abs=1e-3)


def test_minimal_tutorial_robot_is_refused_with_the_massless_link():
    with pytest.raises(RobotDescriptionError, match="'right_thigh'"):
        wbc.robot.load(CHAPTER)


@pytest.mark.parametrize(
    ("stated", "complaint"),
    [
        ({"left_foot": "leftfoot"}, "no such link; did you mean 'left_foot'"),
        ({"right_foot": "left_foot"}, "moved by the same joint"),
        ({"torso": "tors"}, "torso is 'tors'.*did you mean 'torso'"),
        ({"imu": "imu"}, "imu is 'imu', but the model has no such frame"),
        ({"nominal_posture": {"left_kne": 0.3}}, "no joint 'left_kne'; did you mean 'left_knee'"),
        ({"armature": {"knees": 0.3}}, "no joint 'knees'"),
        ({"fixed_joints": ["wings"]}, "'wings', which is no joint"),
        ({"sole": {"height": 0.0}}, "height, length and width"),
        ({"sole": {"hight": 0.0}}, "no 'hight'; did you mean 'height'"),
        ({"sole": {"height": 0.0, "length": -1, "width": 1}}, "'sole.length' is -1; .*positive, m"),
        ({"sole": {"height": 0.0, "length": 1, "width": 1, "center": 3}}, "'sole.center' is 3"),
        ({"armature": -1}, "'armature' is -1; it must be zero or a positive"),
        ({"armature": float("nan")}, "'armature' is nan"),
        ({"armature": {"left_knee": -0.1}}, "'armature.left_knee' is -0.1"),
        ({"nominal_posture": {"left_knee": float("nan")}}, "'nominal_posture.left_knee' is nan"),
        ({"nominal_posture": [0.3]}, "a table of joint names"),
        ({"effort_limits": {"left_knee": 0.0}}, "'effort_limits.left_knee' is 0.0; .*positive"),
        ({"effort_limits": {"knee": 5.0}}, "effort_limits: the model has no joint 'knee'"),
        ({"velocity_limits": {"left_knee": -2}}, "'velocity_limits.left_knee' is -2"),
        ({"fixed_joints": "*elbow"}, "'fixed_joints' is .*a list of joint names"),
        ({"package_dirs": "/tmp"}, "'package_dirs' is '/tmp'; it must be a list of folders"),
        ({"name": 3}, "'name' is 3; it must be a name"),
        ({"respect_up_axis": "yes"}, "true or false"),
    ],
)
def test_an_invalid_argument_of_load_is_refused_by_name(stated, complaint):
    with pytest.raises(RobotDescriptionError, match=complaint):
        wbc.robot.load("simple_humanoid", **stated)


def test_a_robot_without_recognised_feet_asks_for_their_names():
    with pytest.raises(RobotDescriptionError, match="state both, left_foot=… and right_foot=…"):
        wbc.robot.load("centauro")
    with pytest.raises(RobotDescriptionError, match="right_foot is not; state both"):
        wbc.robot.load("icub_reduced", left_foot="l_sole")


def test_a_foot_without_shape_asks_for_its_sole():
    with pytest.raises(RobotDescriptionError, match=r"no surface to stand on.*\[sole\]"):
        wbc.robot.load("simple_humanoid_classical")


def test_a_foot_whose_mesh_is_missing_names_the_mesh(tmp_path):
    foot = element("link", "left_foot")
    shape = '<mesh filename="package://nowhere/foot.stl"/>'
    bare = foot.replace(foot[foot.index("    <visual>") : foot.index("    <collision>")], "")
    bare = bare.replace('<box size="0.22 0.1 0.04"/>', shape)
    path = changed(tmp_path, (foot, bare))
    with pytest.raises(
        RobotDescriptionError, match=r"its mesh package://nowhere/foot\.stl is missing"
    ):
        load(path)
    robot = load(path, sole={"height": -0.08, "length": 0.2, "width": 0.1, "center": (0.04, 0)})
    assert robot.soles[0].placement.translation == pytest.approx([0.04, 0, -0.08])
    assert len(robot.collision_model.geometryObjects) == 22


def test_every_error_is_the_librarys_own_and_one_line(tmp_path):
    """Cut our URDF short anywhere: never another exception, never a success."""
    text = changed(tmp_path).read_text()
    path = tmp_path / "cut.urdf"
    for length in range(0, len(text) - 10, 997):
        path.write_text(text[:length])
        with pytest.raises(WbcError) as caught:
            load(path)
        assert "\n" not in str(caught.value)


def wheel(side: str) -> str:
    """A foot's link and joint, as a wheel that turns without limit."""
    return (
        f'<link name="{side}_wheel"><inertial><mass value="2"/>'
        '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
        '<collision><origin rpy="1.5708 0 0"/><geometry><cylinder radius="0.08" length="0.04"/>'
        f'</geometry></collision></link><joint name="{side}_axle" type="continuous">'
        f'<parent link="{side}_shin"/><child link="{side}_wheel"/><origin xyz="0 0 -0.38"/>'
        '<axis xyz="0 1 0"/><limit effort="20" velocity="30"/></joint>'
    )


def test_wheels_as_feet_are_refused_by_name_with_the_cure(tmp_path):
    path = changed(tmp_path, ("</robot>", wheel("left") + wheel("right") + "</robot>"))
    feet = {"left_foot": "left_wheel", "right_foot": "right_wheel"}
    text = r"the foot 'left_wheel' is a wheel.*'left_axle'.*fixed_joints=\['left_axle'\]"
    with pytest.raises(RobotDescriptionError, match=text):
        wbc.robot.load(path, **feet)
    (finding,) = [f for f in wbc.robot.check_file(path, **feet) if f.severity == "error"]
    assert "'left_wheel' is a wheel" in finding.what
    assert "fixed_joints=['left_axle']" in finding.cure
    # Blocked wheels are feet without ankles.
    assert wbc.robot.load(path, **feet, fixed_joints=["*_axle"]).soles[0].link == "left_wheel"
    assert wbc.robot.load(path, **FEET).soles[0].link == "left_foot"


def test_legs_without_a_knee_load_with_a_finding_and_a_walker_error():
    fixed = ("*_knee", "*_ankle_pitch")
    robot = wbc.robot.load("simple_humanoid", fixed_joints=fixed)
    assert ("no-knee", "left_foot") in codes(robot.check())
    with pytest.raises(GaitError, match=r"'simple_humanoid' cannot walk.*left leg.*knee"):
        wbc.Walker(robot)


def test_legs_of_one_joint_are_refused_by_the_walker():
    names = ("hip_yaw", "hip_roll", "knee", "ankle_pitch", "ankle_roll")
    robot = wbc.robot.load("simple_humanoid", fixed_joints=[f"*_{name}" for name in names])
    assert ("no-knee", "right_foot") in codes(robot.check())
    with pytest.raises(GaitError, match="1 joint"):
        wbc.Walker(robot)
