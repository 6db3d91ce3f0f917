"""The options that complete a URDF or override what is known about a robot."""

from __future__ import annotations

import numpy as np
import pytest

import wbc
from wbc.cli import main
from wbc.cli.model_options import ModelOptions
from wbc.cli.parser import Parser, set_command

FEET = ("--left-foot", "left_foot", "--right-foot", "right_foot")
NAMED = ("walk", "stand", "live", "view", "robots", "doctor")


@pytest.fixture(scope="module")
def urdf():
    return str(wbc.load("simple_humanoid").urdf_path)


def load(name: str, *options: str) -> wbc.Robot:
    def command(model: ModelOptions) -> wbc.Robot:
        return model.load(name)

    parser = Parser()
    set_command(parser, command)
    parsed = parser.parse_args(options)
    return parsed.execute(parsed)


def test_limits_and_armature_are_those_of_the_options(urdf):
    robot = load(
        urdf, *FEET, "--effort-limit", "left_knee=12.5", "--effort-limit", "right_knee=13",
        "--velocity-limit", "left_knee=3", "--armature", "0.02",
    )  # fmt: skip
    left, right = robot.joint_index("left_knee"), robot.joint_index("right_knee")
    assert (robot.tau_max[left], robot.tau_max[right], robot.v_max[left]) == (12.5, 13.0, 3.0)
    assert np.all(robot.model.armature[6:] == 0.02)


def test_the_posture_is_that_of_the_options(urdf):
    robot = load(urdf, *FEET, "--posture", "left_elbow=0.5", "--posture", "right_elbow=-0.25")
    q = robot.q_nominal[7:]
    assert q[robot.joint_index("left_elbow")] == 0.5
    assert q[robot.joint_index("right_elbow")] == -0.25


def test_fixed_joints_are_not_actuated(urdf):
    robot = load(urdf, *FEET, "--fixed-joint", "*elbow*")
    assert robot.na == load(urdf, *FEET).na - 2
    assert not any("elbow" in name for name in robot.joint_names)


def test_packages_are_found_in_the_folders_of_the_options(urdf, tmp_path):
    robot = load(urdf, *FEET, "--package-dir", str(tmp_path), "--package-dir", "/")
    assert tmp_path in robot.package_dirs


@pytest.mark.parametrize("command", NAMED)
def test_every_subcommand_that_loads_a_robot_has_the_options(command, capsys):
    assert main((command, "--help")) == 0
    out = capsys.readouterr().out
    for option in ("--left-foot", "--posture", "--effort-limit", "--fixed-joint", "--package-dir"):
        assert option in out


def test_the_properties_of_a_urdf_are_listed_under_its_own_name(urdf, tmp_path, capsys):
    file = tmp_path / "robot.urdf"
    with open(urdf) as original:
        file.write_text(original.read())
    assert main(("robots", str(file), *FEET)) == 0
    assert capsys.readouterr().out.startswith("simple_humanoid: 20 joints")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--effort-limit", "left_knee"), "'left_knee' is not of the form JOINT=VALUE"),
        (("--effort-limit", "left_knee=x"), "'x' is not a number"),
        (("--effort-limit", "left_kne=1"), "did you mean 'left_knee'"),
        (("--posture", "nose=1"), "'nose'"),
        (("--fixed-joint", "nose"), "'nose'"),
        (("--armature", "-1"), "armature"),
    ],
)
def test_an_invalid_option_is_named(options, words, urdf, capsys):
    assert main(("robots", urdf, *FEET, *options)) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert words in err
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize("name", ["xyzzy", "walker", "qqqqqq"])
def test_no_name_is_suggested_where_none_is_similar(name, capsys):
    assert main(("robots", name)) == 2
    assert "did you mean" not in capsys.readouterr().err
