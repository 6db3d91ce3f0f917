"""A quantity that is declared once appears in the log, the plots, the page's list and ROS."""

import numpy as np
import pytest

import wbc
from wbc.live.signals import signal_places
from wbc.log import FlightRecorder, LogError, LoggedRun, plot
from wbc.runtime.schema import Quantity
from wbc.runtime.stream import TickStream
from wbc.topics import tick_topics

POWER = Quantity(
    "joint_power",
    lambda tick: tick.command.tau * tick.estimate.state.v[6:],
    "mechanical power of each joint",
    unit="W",
    size="na",
)
TOTAL = Quantity("total_power", lambda tick: tick.command.tau @ tick.estimate.state.v[6:], "", "W")


@pytest.fixture(scope="module")
def robot():
    return wbc.load("simple_humanoid")


@pytest.fixture(scope="module")
def run(robot, tmp_path_factory):
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    with FlightRecorder(path, robot) as log, wbc.sim.Mujoco(robot) as plant:
        wbc.run(wbc.Walker(robot), plant, 0.1, observers=[log], quantities=[POWER, TOTAL])
    return LoggedRun.read(path)


def test_own_quantity_is_logged_with_its_name_unit_and_labels(run, robot):
    column, power = run.quantities["joint_power"], run["joint_power"]
    assert (column.unit, column.labels) == ("W", robot.joint_names)
    np.testing.assert_allclose(power, run["tau"] * run["v"][:, 6:], rtol=1e-12)
    np.testing.assert_allclose(run["total_power"], power.sum(axis=1), atol=1e-9)
    assert run.log["/wbc/joint_power"].type_name == "std_msgs/msg/Float64MultiArray"
    assert run.log["/wbc/total_power"].type_name == "std_msgs/msg/Float64"


def test_every_quantity_of_the_library_is_logged(run):
    names = {"q", "v", "tau", "com", "dcm", "zmp", "foot_wrench/left_sole", "heading", "true_q"}
    assert names <= set(run.quantities)
    with pytest.raises(LogError, match="no quantity 'torque'"):
        run["torque"]


def test_own_quantity_is_plotted_by_its_name(run, tmp_path):
    pytest.importorskip("matplotlib")
    (path,) = plot(run, tmp_path, quantities=["joint_power"])
    assert path.name == "run_joint_power.png"
    assert path.stat().st_size > 10_000


def test_the_page_offers_it(robot):
    series = signal_places(TickStream(robot, [POWER, TOTAL]).schema)
    assert f"joint_power: {robot.joint_names[3]}, W" in series
    assert "total_power, W" in series
    assert "com: z, m" in series


def test_the_log_and_the_node_share_topics_and_frames(robot):
    topics = {t.name: t for t in tick_topics(TickStream(robot, [POWER]).schema, robot)}
    assert topics["wbc/joint_power"].type_name == "std_msgs/msg/Float64MultiArray"
    assert {"joint_states", "odom", "balance/dcm", "balance/cop", "/tf", "/tf_static"} <= set(
        topics
    )


def test_points_and_odometry_of_the_log_are_in_the_frame_of_ros(run):
    assert run.log["/balance/com"].first.header.frame_id == "odom"
    assert run.log["/odom"].first.header.frame_id == "odom"
    transforms = run.log["/tf"].first.transforms
    assert (transforms[0].header.frame_id, transforms[0].child_frame_id) == (
        "odom",
        run.robot_info.base,
    )


def test_ros_node_publishes_an_own_quantity(robot):
    pytest.importorskip("cyclonedds")
    from rostools import TIMEOUT, node, unused_domain

    from wbc.motions import MotionPlayer
    from wbc.ros import Network
    from wbc.ros.bridge import Bridge
    from wbc.teleop import CommandHandler

    player, domain = MotionPlayer(robot), unused_domain()
    received = []
    with (
        wbc.sim.Mujoco(robot) as plant,
        CommandHandler(player, plant, owns_clock=False) as handler,
        Bridge(handler, network=Network(domain)) as bridge,
        node("listener", domain) as listener,
    ):
        listener.create_subscription("std_msgs/msg/Float64", "/wbc/total_power", received.append)

        def before_tick(now):
            if received:
                raise wbc.StopRun("received")
            listener.spin_once(0.0)

        wbc.run(
            player,
            plant,
            TIMEOUT,
            observers=[bridge],
            quantities=[TOTAL],
            before_tick=before_tick,
            real_time=True,
        )
    assert np.isfinite(received[0].data)
