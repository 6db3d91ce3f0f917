"""Robot data files, what a caller states over them, and where packages are found."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from robottools import FEET, ROBOTS, SIMPLE, changed

import wbc.robot
from wbc.errors import RobotDescriptionError
from wbc.robot.packages import example_robot_data, resolve, search_folders

ROOT = ROBOTS.parent


def write(folder: Path, text: str) -> Path:
    shutil.copy(SIMPLE, folder / "r.urdf")
    path = folder / "r.toml"
    path.write_text(text)
    return path


def test_a_data_file_of_the_users_own_loads(tmp_path):
    path = write(
        tmp_path,
        """
        urdf = "r.urdf"
        name = "mine"
        left_foot = "left_foot"
        right_foot = "right_foot"
        imu = "torso"
        fixed_joints = ["neck"]
        [armature]
        default = 0.01
        left_knee = 0.07
        [nominal_posture]
        left_knee = 0.4
        left_hip_pitch = -0.2
        left_ankle_pitch = -0.2
        right_knee = 0.4
        right_hip_pitch = -0.2
        right_ankle_pitch = -0.2
        [effort_limits]
        left_knee = 77
        [velocity_limits]
        left_knee = 5.5
        """,
    )
    robot = wbc.robot.load(path)
    knee = robot.joint_index("left_knee")
    assert robot.name == "mine"
    assert robot.imu == "torso"
    assert "neck" not in robot.joint_names
    assert robot.tau_max[knee] == 77
    assert robot.v_max[knee] == 5.5
    assert robot.model.armature[6 + knee] == 0.07
    assert robot.model.armature[6] == 0.01
    assert robot.q_nominal[7 + knee] == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("urdf = ", "malformed TOML"),
        ("name = 'x'", "no urdf"),
        ("urdf = 'r.urdf'\nleft_fot = 'x'", "unknown key 'left_fot'; did you mean 'left_foot'"),
        ("urdf = 'r.urdf'\nleft_foot = 3", "'left_foot' is 3; it must be a name"),
        ("urdf = 'r.urdf'\narmature = -0.1", "armature.* positive"),
        ("urdf = 'r.urdf'\narmature = 'big'", "must be zero or a positive rotor inertia"),
        ("urdf = 'r.urdf'\nnominal_posture = 3", "must be a table"),
        ("urdf = 'gone.urdf'", "cannot read .*gone.urdf"),
    ],
)
def test_an_invalid_data_file_is_refused_with_the_key(tmp_path, text, complaint):
    with pytest.raises(RobotDescriptionError, match=complaint):
        wbc.robot.load(write(tmp_path, text))


def test_arguments_of_load_override_the_data_file():
    robot = wbc.robot.load("simple_humanoid", name="other", torso="head", armature=0.3, imu="torso")
    assert (robot.name, robot.torso, robot.imu) == ("other", "head", "torso")
    assert (robot.model.armature[6:] == 0.3).all()


def test_a_bare_urdf_with_two_feet_named_works():
    robot = wbc.robot.load(SIMPLE, **FEET)
    facts = {fact.name: fact for fact in robot.facts}
    assert facts["nominal posture"].value.startswith("knees bent")
    knee = 7 + robot.joint_index("left_knee")
    assert robot.q_nominal[knee] == pytest.approx(0.4, abs=0.02)
    assert robot.q_nominal[knee] == pytest.approx(
        robot.q_nominal[7 + robot.joint_index("right_knee")]
    )


def test_a_derived_posture_puts_the_mass_over_the_soles():
    import pinocchio as pin

    robot = wbc.robot.load(SIMPLE, **FEET)
    com = pin.centerOfMass(robot.model, robot.model.createData(), robot.q_nominal)
    np.testing.assert_allclose(com[:2], 0, atol=1e-4)


def test_an_srdf_gives_the_posture(tmp_path):
    srdf = tmp_path / "r.srdf"
    srdf.write_text(
        "<robot name='r'><group_state name='crouch' group='all'>"
        + "".join(
            f"<joint name='{side}_{joint}' value='{value}'/>"
            for side in ("left", "right")
            for joint, value in (("hip_pitch", -0.62), ("knee", 1.2), ("ankle_pitch", -0.58))
        )
        + "<joint name='not_in_this_variant' value='1'/></group_state>"
        "<group_state name='standing' group='all'/></robot>"
    )
    standing = wbc.robot.load("simple_humanoid", srdf=srdf)
    assert standing.q_nominal[7 + standing.joint_index("left_knee")] == pytest.approx(0, abs=0.1)
    text = write(tmp_path, f'urdf = "r.urdf"\nsrdf = "{srdf}"\ngroup_state = "crouch"\n')
    crouching = wbc.robot.load(text, **FEET)
    assert crouching.q_nominal[7 + crouching.joint_index("left_knee")] == pytest.approx(
        1.2, abs=0.1
    )
    text.write_text(f'urdf = "r.urdf"\nsrdf = "{srdf}"\ngroup_state = "couch"\n')
    with pytest.raises(
        RobotDescriptionError, match="no group_state 'couch'; did you mean 'crouch'"
    ):
        wbc.robot.load(text, **FEET)


def test_a_posture_with_the_com_off_the_soles_is_corrected_with_a_finding(tmp_path):
    """Ankles bent alone lean the robot far forward of its feet."""
    lean = {"left_ankle_pitch": -0.3, "right_ankle_pitch": -0.3}
    robot = wbc.robot.load("simple_humanoid", nominal_posture=lean)
    fact = {fact.name: fact.value for fact in robot.facts}["nominal posture"]
    assert "the other leg joints such that the soles are flat" in fact
    assert "unbalanced-posture" not in {finding.code for finding in robot.check()}


def test_mesh_addresses_resolve_through_packages_files_and_neighbours(tmp_path):
    package = tmp_path / "ws" / "my_robot"
    (package / "meshes").mkdir(parents=True)
    (package / "urdf").mkdir()
    mesh = package / "meshes" / "a.stl"
    mesh.write_text("solid")
    urdf = package / "urdf" / "my.urdf"
    folders = search_folders(urdf)
    for address in (
        "package://my_robot/meshes/a.stl",
        "package:///my_robot/meshes/a.stl",
        "model://my_robot/meshes/a.stl",
        f"file://{mesh}",
        "../meshes/a.stl",
        str(mesh),
    ):
        found = resolve(address, urdf, folders)
        assert found is not None, address
        assert found.samefile(mesh)
    assert resolve("package://other/meshes/a.stl", urdf, folders) is None
    elsewhere = tmp_path / "elsewhere.urdf"
    assert resolve("package://my_robot/meshes/a.stl", elsewhere, search_folders(elsewhere)) is None
    told = search_folders(elsewhere, [tmp_path / "ws"])
    assert resolve("package://my_robot/meshes/a.stl", elsewhere, told) is not None


def test_ros_package_path_is_searched(tmp_path, monkeypatch):
    (tmp_path / "ws" / "my_robot").mkdir(parents=True)
    (tmp_path / "ws" / "my_robot" / "a.stl").write_text("solid")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ws"))
    urdf = tmp_path / "x" / "r.urdf"
    assert resolve("package://my_robot/a.stl", urdf, search_folders(urdf)) is not None


def test_example_robot_data_is_found_without_a_module_of_its_own():
    root = example_robot_data()
    assert root is not None
    assert (root / "robots" / "talos_data").is_dir()
    assert "icub_reduced" in wbc.robot.examples()
    # Two files share the stem, so each goes by its path.
    assert "anymal" not in wbc.robot.examples()


def test_a_continuous_joint_has_one_coordinate_and_no_limits(tmp_path):
    robot = wbc.robot.load(
        changed(tmp_path, ('"neck" type="revolute"', '"neck" type="continuous"')), **FEET
    )
    neck = robot.joint_index("neck")
    assert robot.nq - 7 == robot.na
    assert robot.q_min[neck] == -np.inf
    assert robot.q_max[neck] == np.inf
    assert np.isfinite(robot.q_nominal).all()


def test_a_base_fixed_to_the_world_becomes_floating(tmp_path):
    anchor = (
        '<link name="world"/><joint name="bolt" type="{}"><parent link="world"/>'
        '<child link="base_link"/><origin xyz="0 0 3"/></joint></robot>'
    )
    plain = wbc.robot.load(SIMPLE, **FEET)
    for kind in ("fixed", "floating"):
        path = changed(tmp_path, ("</robot>", anchor.format(kind)))
        robot = wbc.robot.load(path, **FEET)
        assert robot.base == "base_link"
        np.testing.assert_allclose(robot.q_nominal, plain.q_nominal)
        assert len(robot.visual_model.geometryObjects) == len(plain.visual_model.geometryObjects)


def test_absent_limits_get_substitutes_and_findings(tmp_path):
    path = changed(
        tmp_path,
        ('effort="10" velocity="6"', 'effort="0" velocity="0"'),
        ('<limit lower="0" upper="2.4" effort="200" velocity="12"/>', ""),
    )
    robot = wbc.robot.load(path, **FEET)
    neck, knee = robot.joint_index("neck"), robot.joint_index("right_knee")
    assert 1 <= robot.tau_max[neck] < 100
    assert robot.tau_max[knee] > 100  # it has to carry 54 kg
    assert robot.v_max[neck] == robot.v_max[knee] == np.inf
    assert robot.q_max[knee] == pytest.approx(np.pi)
    found = {(finding.code, finding.subject) for finding in robot.findings}
    assert found == {
        (code, joint)
        for code in ("no-effort-limit", "no-velocity-limit")
        for joint in ("neck", "right_knee")
    }


@pytest.mark.skipif(
    not all((ROOT / name).is_file() for name in ("pyproject.toml", "README.md", "LICENSE")),
    reason="not a complete checkout",
)
def test_a_wheel_installed_elsewhere_finds_its_robots(tmp_path):
    command = [
        sys.executable,
        "-m",
        "build",
        "--wheel",
        "--no-isolation",
        "--outdir",
        str(tmp_path),
    ]
    subprocess.run([*command, str(ROOT)], check=True, capture_output=True, timeout=120)
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        archive.extractall(tmp_path / "site")
    for path in ROBOTS.iterdir():
        if path.is_file():
            assert f"wbc/robot/data/{path.name}" in names
    code = (
        "import wbc.robot as r; print(r.__file__, *r.available());"
        "print(r.load('simple_humanoid').mass, r.load('talos').na)"
    )
    environment = {**os.environ, "PYTHONPATH": str(tmp_path / "site")}
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env=environment,
        check=True,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.stdout.startswith(str(tmp_path / "site"))
    assert "simple_humanoid" in done.stdout.splitlines()[0]
    assert done.stdout.splitlines()[1].split()[1] == "32"


def test_robot_name_comes_from_the_caller_the_data_file_or_the_urdf(tmp_path):
    urdf = changed(tmp_path, ('<robot name="simple_humanoid"', '<robot name="Walter"'))
    assert wbc.robot.load(urdf, **FEET).name == "Walter"
    assert wbc.robot.load(urdf, **FEET, name="Wanda").name == "Wanda"
    feet = 'left_foot = "left_foot"\nright_foot = "right_foot"\n'
    for text, name in (("", "butler"), ('name = "Wilma"\n', "Wilma")):
        data_file = tmp_path / "butler.toml"
        data_file.write_text(f'urdf = "{urdf.name}"\n{feet}{text}')
        assert wbc.robot.load(data_file).name == name
    nameless = changed(tmp_path, ('<robot name="simple_humanoid"', "<robot"), name="plain.urdf")
    assert wbc.robot.load(nameless, **FEET).name == "plain"


def test_values_stated_for_a_fixed_joint_are_ignored():
    robot = wbc.robot.load(
        "simple_humanoid", fixed_joints=["*_elbow"], armature={"left_elbow": 0.1}
    )
    assert "left_elbow" not in robot.joint_names
    assert robot.na == 18


def test_limits_of_the_caller_are_added_to_those_of_the_file(tmp_path):
    feet = 'left_foot = "left_foot"\nright_foot = "right_foot"\n'
    limits = "[effort_limits]\nleft_knee = 70.0\nright_knee = 70.0\n"
    path = write(tmp_path, f'urdf = "r.urdf"\n{feet}{limits}')
    robot = wbc.robot.load(path, effort_limits={"left_knee": 50.0})
    knees = [robot.tau_max[robot.joint_index(name)] for name in ("left_knee", "right_knee")]
    assert knees == [50.0, 70.0]
