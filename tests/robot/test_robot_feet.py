"""The feet of robots whose names of links say little: found by their place, or refused."""

from __future__ import annotations

import pytest
from robottools import SIMPLE, changed

import wbc
import wbc.robot
from wbc.errors import RobotDescriptionError, WbcError
from wbc.gait.parameters import GaitParameters
from wbc.motions import Jump
from wbc.robot import load_fixed_base
from wbc.robot.feet import find_feet, foot_pairs, mirror
from wbc.robot.urdf import parse_urdf, read_xml


def urdf_of(path):
    return parse_urdf(path, *read_xml(path))


def test_feet_that_no_name_tells_are_the_lowest_ends_of_the_legs(tmp_path):
    path = tmp_path / "nameless.urdf"
    path.write_text(SIMPLE.read_text().replace("_foot", "_end").replace("ankle", "axis"))
    robot = wbc.load(path)
    assert [sole.link for sole in robot.soles] == ["left_end", "right_end"]
    facts = {fact.name: fact for fact in robot.facts}
    assert facts["left foot"].origin == "derived"
    assert "end of a leg" in facts["left foot"].source


@pytest.mark.parametrize("name", ["centauro", "panda", "tiago"])
def test_a_robot_without_feet_is_refused(name):
    with pytest.raises(RobotDescriptionError, match="a robot needs two feet"):
        wbc.load(name)


def test_a_robot_with_one_leg_is_refused():
    weld = "left_hip_*", "left_knee", "left_ankle_*"
    with pytest.raises(RobotDescriptionError, match="'left_foot' is moved by no joint"):
        wbc.load(SIMPLE, fixed_joints=weld)


@pytest.mark.parametrize(
    ("name", "mirrored"),
    [("leftfoot", "rightfoot"), ("LeftFoot", "RightFoot"), ("upright_foot", None)],
)
def test_sides_are_read_from_names_without_separators(name, mirrored):
    assert mirror(name) == mirrored


def test_a_link_fixed_to_the_foot_is_the_same_foot(tmp_path):
    tips = "".join(
        f'<link name="{side}_foot_tip"/><joint name="{side}_tip" type="fixed">'
        f'<parent link="{side}_foot"/><child link="{side}_foot_tip"/></joint>'
        for side in ("left", "right")
    )
    urdf = urdf_of(changed(tmp_path, ("</robot>", f"{tips}</robot>")))
    assert foot_pairs(urdf) == [("left_foot", "right_foot")]
    assert find_feet(urdf) == ("left_foot", "right_foot")


def test_links_and_joints_of_the_same_names_are_no_obstacle_to_walking(tmp_path):
    same = [
        (f'joint name="{joint}"', f'joint name="{link}"')
        for joint, link in (("neck", "head"), ("torso_yaw", "torso"))
    ]
    robots = wbc.load(changed(tmp_path, *same)), wbc.load(SIMPLE)
    limits = [GaitParameters.for_robot(robot).max_velocity.largest for robot in robots]
    assert limits[0] == pytest.approx(limits[1])


@pytest.mark.parametrize("kind", ["planar", "prismatic"])
def test_a_base_that_does_not_float_is_refused_with_the_joint(tmp_path, kind):
    world = '<link name="world"/><joint name="rail" type="{}"><parent link="world"/>'
    world += '<child link="base_link"/><axis xyz="1 0 0"/>'
    world += '<limit lower="-1" upper="1" effort="10" velocity="1"/></joint></robot>'
    path = changed(tmp_path, ("</robot>", world.format(kind)))
    with pytest.raises(RobotDescriptionError, match=r"'rail'.*base"):
        wbc.load(path)


def test_a_fixed_base_is_no_walker_but_loads_as_one(tmp_path):
    world = '<link name="world"/><joint name="bolts" type="fixed"><parent link="world"/>'
    path = changed(tmp_path, ("</robot>", f'{world}<child link="base_link"/></joint></robot>'))
    assert wbc.load(path).model.joints[1].shortname() == "JointModelFreeFlyer"
    assert load_fixed_base(path).na == wbc.load(SIMPLE).na


@pytest.mark.parametrize(
    "use",
    [
        wbc.WholeBodyController,
        wbc.Walker,
        wbc.QuadrupedWalker,
        wbc.Estimator,
        wbc.GroundTruthEstimator,
        wbc.sim.Mujoco,
        wbc.view.Meshcat,
        wbc.motions.MotionPlayer,
        wbc.ik.PostureIK,
    ],
)
def test_what_needs_feet_refuses_a_fixed_base_and_a_name(use):
    with pytest.raises(WbcError, match=r"the base of 'panda' is fixed; wbc\.InverseKinematics"):
        use(load_fixed_base("panda"))
    with pytest.raises(WbcError, match=r"takes a robot, such as wbc\.load\('talos'\), not 'g1'"):
        use("g1")


def test_the_package_of_a_clone_is_that_of_its_package_xml(tmp_path):
    clone = tmp_path / "clone"
    (clone / "urdf").mkdir(parents=True)
    (clone / "foot.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (clone / "package.xml").write_text("<package><name> butler </name></package>")
    urdf = clone / "urdf" / "robot.urdf"
    folders = wbc.robot.packages.search_folders(urdf)
    found = wbc.robot.packages.resolve("package://butler/foot.obj", urdf, folders)
    assert found == clone / "foot.obj"


def test_a_waist_below_the_base_belongs_to_no_leg(tmp_path):
    mass = '<inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01"/></inertial>'
    waist = f'<link name="hips">{mass}</link><joint name="waist" type="revolute">'
    waist += '<parent link="base_link"/><child link="hips"/><axis xyz="0 0 1"/>'
    waist += '<limit lower="-1" upper="1" effort="100" velocity="10"/></joint></robot>'
    child = '<parent link="{}"/><child link="{}_hip"/>'
    moved = [
        (child.format("base_link", side), child.format("hips", side)) for side in ("left", "right")
    ]
    robot = wbc.load(changed(tmp_path, *moved, ("</robot>", waist)))
    assert [len(leg) for leg in robot.legs] == [6, 6]
    plan = Jump().plan(robot)
    assert plan.clearance == pytest.approx(0.05)


@pytest.mark.parametrize(("text", "metres"), [('<unit meter="0.01" name="cm"/>', 0.01), ("", 1.0)])
def test_the_unit_of_a_collada_file_is_known(tmp_path, text, metres):
    mesh = tmp_path / "head.dae"
    mesh.write_text(f"<COLLADA><asset>{text}</asset></COLLADA>")
    assert wbc.robot.packages.mesh_unit(mesh) == metres
