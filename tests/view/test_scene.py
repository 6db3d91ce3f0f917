"""What is drawn stands where the snapshot says."""

import numpy as np
import pinocchio as pin
import pytest

import wbc
from wbc.command import Status
from wbc.geometry.wrench import centre_of_pressure
from wbc.telemetry import ContactPlan, Footstep, Telemetry
from wbc.view import Snapshot, ViewerError
from wbc.view.actors.support import cover_triangle
from wbc.view.scene import Scene


@pytest.fixture(scope="module")
def robot():
    return wbc.load("simple_humanoid")


@pytest.fixture(scope="module")
def drawn(robot):
    return Scene(robot)


@pytest.fixture
def scene(drawn):
    drawn._time = None  # a new run
    return drawn


def poses(scene, prefix):
    rows = [i for i, node in enumerate(scene.nodes) if node.path.startswith(prefix)]
    return scene.poses[rows]


def seen(scene, prefix):
    rows = poses(scene, prefix)
    return rows[rows[:, 7] > 0]


def matrix(row):
    result = pin.XYZQUATToSE3(row[:7]).homogeneous
    result[:3, :3] *= row[7:]
    return result


def test_every_joint_that_carries_a_shape_is_placed(robot, scene):
    q = pin.integrate(robot.model, robot.q_nominal, np.full(robot.nv, 0.2))
    assert scene.update(Snapshot(0.0, q))
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, q)
    for node, row in zip(scene.nodes, scene.poses, strict=True):
        if node.path.startswith("robot/"):
            joint = robot.model.getJointId(node.path.removeprefix("robot/"))
            np.testing.assert_allclose(matrix(row), data.oMi[joint].homogeneous, atol=1e-9)


def test_a_force_arrow_begins_at_the_centre_of_pressure_and_points_along_the_force(robot, scene):
    force = np.array([30.0, -20.0, 0.5 * scene.proportions.weight])
    scene_input = np.array([4.0, -6.0, 0.0])
    wrench = np.concatenate([force, scene_input])
    scene.update(Snapshot(0.0, robot.q_nominal, {"left_sole": wrench}))
    shaft, head = seen(scene, "forces/")
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.q_nominal)
    sole = data.oMf[robot.sole("left").frame_id]
    start = matrix(shaft) @ [0, 0, -0.5, 1]
    np.testing.assert_allclose(start[:3], sole.act(centre_of_pressure(wrench)), atol=1e-9)
    tip = matrix(head) @ [0, 0, 0.5, 1]
    way = (tip - start)[:3]
    direction = sole.rotation @ force / np.linalg.norm(force)
    np.testing.assert_allclose(way / np.linalg.norm(way), direction, atol=1e-6)


def test_the_length_of_an_arrow_is_proportional_to_the_force(robot, scene):
    lengths = []
    for part in (0.4, 0.8):
        force = np.array([0, 0, part * scene.proportions.weight, 0, 0, 0])
        scene.update(Snapshot(0.0, robot.q_nominal, {"left_sole": force}))
        lengths.append(sum(row[9] for row in seen(scene, "forces/")))
    assert lengths[1] == pytest.approx(2 * lengths[0])


def test_an_unloaded_contact_has_no_arrow(robot, scene):
    scene.update(Snapshot(0.0, robot.q_nominal, {"left_sole": np.zeros(6)}))
    assert len(seen(scene, "forces/")) == 0


def test_the_centre_of_pressure_of_a_shifted_vertical_force_is_the_shift():
    shift, force = np.array([0.03, -0.02, 0.0]), np.array([0.0, 0.0, 400.0])
    wrench = np.concatenate([force, np.cross(shift, force)])
    np.testing.assert_allclose(centre_of_pressure(wrench), shift)
    np.testing.assert_array_equal(centre_of_pressure(np.zeros(6)), np.zeros(3))


def test_markers_are_at_their_points_and_unknown_ones_are_hidden(robot, scene):
    dcm, zmp = np.array([0.1, 0.02, 0.0]), np.array([-0.03, 0.04, 0.0])
    scene.update(Snapshot(0.0, robot.q_nominal, telemetry=Telemetry(dcm=dcm, zmp=zmp)))
    (row,) = seen(scene, "balance/zmp")
    np.testing.assert_allclose(row[:2], zmp[:2])
    assert [len(seen(scene, f"balance/{n}")) for n in ("dcm", "dcm_reference")] == [1, 0]
    (com,) = poses(scene, "balance/com")[:1]
    data = robot.model.createData()
    expected = pin.centerOfMass(robot.model, data, robot.q_nominal)
    np.testing.assert_allclose(com[:3], expected, atol=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_triangle_is_covered_by_two_scaled_right_triangles(seed):
    corners = np.column_stack([np.random.default_rng(seed).normal(size=(3, 2)), np.zeros(3)])
    rows = np.zeros((2, 10))
    cover_triangle(rows, *corners)
    unit = np.array([[0, 0, 0, 1.0], [1, 0, 0, 1], [0, 1, 0, 1]])
    pieces = [(matrix(row) @ unit.T).T[:, :2] for row in rows]

    def area(p):
        u, v = p[1] - p[0], p[2] - p[0]
        return 0.5 * abs(u[0] * v[1] - u[1] * v[0])

    assert sum(map(area, pieces)) == pytest.approx(area(corners[:, :2]))
    for piece in pieces:
        barycentric = np.linalg.solve(
            np.vstack([corners[:, :2].T, np.ones(3)]), _homogeneous(piece)
        )
        assert barycentric.min() > -1e-9


def _homogeneous(points):
    return np.vstack([points.T, np.ones(len(points))])


def test_the_support_polygon_has_an_edge_per_side_and_a_filling(robot, scene):
    support = np.array([[0, 0, 0], [0.2, 0, 0], [0.2, 0.1, 0], [0.1, 0.2, 0], [0, 0.1, 0.0]])
    scene.update(Snapshot(0.0, robot.q_nominal, contact_plan=ContactPlan(support=support)))
    assert len(seen(scene, "support/edge")) == 5
    filling = seen(scene, "support/fill")
    area = 0.5 * (filling[:, 7] * filling[:, 8]).sum()
    assert area == pytest.approx(0.03)


def test_planned_footsteps_are_drawn_by_side(robot, scene):
    steps = tuple(Footstep(side, np.full(3, 0.1), 0.3) for side in ("left", "right", "left"))
    scene.update(Snapshot(0.0, robot.q_nominal, contact_plan=ContactPlan(footsteps=steps)))
    assert len(seen(scene, "footsteps/planned_left")) == 2
    (row,) = seen(scene, "footsteps/planned_right")
    heading = matrix(row)[:3, 0]
    np.testing.assert_allclose(heading, [np.cos(0.3), np.sin(0.3), 0.0], atol=1e-9)


def test_a_touchdown_leaves_a_footprint(robot, scene):
    loaded = {"left_sole": np.array([0, 0, 0.5 * scene.proportions.weight, 0, 0, 0])}
    q = robot.q_nominal.copy()
    scene.update(Snapshot(0.0, q, loaded))
    assert len(seen(scene, "footsteps/completed_left")) == 1
    scene.update(Snapshot(0.1, q, loaded))
    assert len(seen(scene, "footsteps/completed_left")) == 1  # it stands where it stood
    scene.update(Snapshot(0.2, q, {"left_sole": np.zeros(6)}))
    q[0] += 0.3
    scene.update(Snapshot(0.3, q, loaded))
    prints = seen(scene, "footsteps/completed_left")
    assert np.ptp(prints[:, 0]) == pytest.approx(0.3, abs=1e-6)
    assert len(seen(scene, "footsteps/completed_right")) == 0


def test_an_earlier_time_begins_a_new_run(robot, scene):
    q = robot.q_nominal.copy()
    for k in range(30):
        q[0] += 0.05
        scene.update(Snapshot(0.1 * k, q))
    assert len(seen(scene, "trail/")) > 10
    scene.update(Snapshot(0.0, robot.q_nominal))
    assert len(seen(scene, "trail/")) == 0


def test_trail_has_a_bounded_length(robot, scene):
    q = robot.q_nominal.copy()
    for k in range(400):
        q[0] += 0.05
        scene.update(Snapshot(0.1 * k, q))
    trail = seen(scene, "trail/")
    assert len(trail) <= len(poses(scene, "trail/"))
    assert trail[:, 0].max() > q[0] - 0.2


def test_camera_follows_smoothly_and_the_floor_moves_by_whole_tiles(robot, scene):
    q = robot.q_nominal.copy()
    aims = []
    for k in range(60):
        q[0] += 0.05
        scene.update(Snapshot(k / 30, q))
        aims.append(poses(scene, "/Cameras/default")[0, 0])
        floor = poses(scene, "surroundings")[0]
        assert floor[0] == round(floor[0])
    assert np.all(np.diff(aims) >= 0)
    assert np.diff(aims).max() < 0.06
    assert q[0] - aims[-1] < 1.0


@pytest.mark.parametrize("status", list(Status))
def test_status_light_has_the_colour_of_the_status(robot, scene, status):
    scene.update(Snapshot(0.0, robot.q_nominal, status=status))
    lit = [n.path for n, row in zip(scene.nodes, scene.poses, strict=True) if row[7] > 0]
    assert [path for path in lit if path.startswith("status_light/")] == [
        f"status_light/{status.value}"
    ]


def test_a_configuration_that_is_not_finite_keeps_the_scene(robot, scene):
    scene.update(Snapshot(0.0, robot.q_nominal))
    before = scene.poses.copy()
    assert not scene.update(Snapshot(0.1, np.full(robot.nq, np.nan)))
    np.testing.assert_array_equal(scene.poses, before)


def test_non_finite_values_hide_only_their_own_marker(robot, scene):
    bad = ContactPlan(
        footsteps=(Footstep("left", np.zeros(3), np.nan),), support=np.full((4, 3), np.nan)
    )
    wrenches = {"left_sole": np.full(6, np.nan)}
    assert scene.update(Snapshot(0.0, robot.q_nominal, wrenches, contact_plan=bad))
    assert np.isfinite(scene.poses).all()
    assert len(seen(scene, "balance/com")) == 2


def test_terrain_is_drawn_as_one_object(robot):
    boxes = np.array([[1.0, 0, 0.01, 0.2, 0.2, 0.01], [1.4, 0, 0.02, 0.2, 0.2, 0.02]])
    scene = Scene(robot, boxes)
    flat = Scene(robot)
    assert len(list(scene.commands())) == len(list(flat.commands())) + 1
    with pytest.raises(ViewerError, match=r"boxes has shape \(2, 5\)"):
        Scene(robot, boxes[:, :5])
