"""Robots look like their meshes; without any they are still seen."""

import re

import coal
import numpy as np
import pinocchio as pin
import pytest
from trimesh import Trimesh, creation

import wbc
from wbc.view.objects import creased, sphere
from wbc.view.shapes import shapes_of
from wbc.view.terrain import box_mesh, checked_boxes
from wbc.view.visuals import ellipsoid, visuals_of

QUAD = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
 <asset><unit meter="0.01" name="cm"/><up_axis>Y_UP</up_axis></asset>
 <library_effects><effect id="red-fx"><profile_COMMON><technique sid="c"><phong>
  <diffuse><color>0.8 0.2 0.4 1</color></diffuse></phong></technique></profile_COMMON></effect>
 </library_effects>
 <library_materials><material id="red"><instance_effect url="#red-fx"/></material>
 </library_materials>
 <library_geometries><geometry id="quad"><mesh>
  <source id="pos"><float_array id="a" count="12">0 0 0 10 0 0 10 10 0 0 10 0</float_array>
   <technique_common><accessor source="#a" count="4" stride="3"><param name="X" type="float"/>
   <param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common>
  </source>
  <vertices id="ver"><input semantic="POSITION" source="#pos"/></vertices>
  <polylist material="M" count="1">
   <input semantic="VERTEX" source="#ver" offset="0"/><vcount>4</vcount><p>0 1 2 3</p></polylist>
 </mesh></geometry></library_geometries>
 <library_visual_scenes><visual_scene id="s"><node id="outer">
  <translate>100 0 0</translate><rotate>0 0 1 90</rotate>
  <node id="inner"><scale>2 2 2</scale><instance_geometry url="#quad"><bind_material>
   <technique_common><instance_material symbol="M" target="#red"/></technique_common>
  </bind_material></instance_geometry></node></node></visual_scene></library_visual_scenes>
 <scene><instance_visual_scene url="#s"/></scene>
</COLLADA>"""


def geometry_object(shape, path="", scale=1.0):
    """Return a geometry object at x = 1 m with a stated colour."""
    return pin.GeometryObject(
        "thing", 0, 0, pin.SE3(np.eye(3), np.array([1.0, 0, 0])), shape, str(path),
        np.full(3, scale), True, np.array([0.1, 0.9, 0.1, 0.5]),
    )  # fmt: skip


def test_collada_keeps_placements_units_and_colours(tmp_path):
    path = tmp_path / "quad.dae"
    path.write_text(QUAD)
    ((shape, colour),) = shapes_of(geometry_object(coal.Sphere(1.0), path, scale=3.0))
    np.testing.assert_allclose(colour, (0.8, 0.2, 0.4, 1.0), atol=0.002)
    assert len(shape.faces) == 2
    # 10 cm, twice as large, rotated by 90° about z, at x = 1 m, three times as large, at x = 1 m.
    np.testing.assert_allclose(shape.bounds, [[3.4, 0.0, 0.0], [4.0, 0.6, 0.0]], atol=1e-6)


@pytest.mark.parametrize("text", ["no xml", "<COLLADA/>", QUAD.replace("#quad", "#none")])
def test_a_mesh_file_that_cannot_be_read_is_replaced_by_its_collision_geometry(
    tmp_path, text, caplog
):
    path = tmp_path / "broken.dae"
    path.write_text(text)
    ((shape, colour),) = shapes_of(geometry_object(coal.Box(1.0, 2.0, 3.0), path))
    np.testing.assert_allclose(shape.extents, [1.0, 2.0, 3.0])
    assert colour == pytest.approx((0.1, 0.9, 0.1, 0.5))


@pytest.mark.parametrize("name", ["romeo", "icub", "talos"])
def test_mesh_files_fill_the_same_space_as_pinocchios(name):
    for thing in wbc.load(name).visual_model.geometryObjects:
        if not thing.meshPath.lower().endswith((".dae", ".stl")):
            continue
        ours = np.concatenate([shape.vertices for shape, _ in shapes_of(thing)])
        theirs = thing.geometry.vertices() @ thing.placement.rotation.T
        theirs += thing.placement.translation
        np.testing.assert_allclose(ours.min(0), theirs.min(0), atol=1e-5)
        np.testing.assert_allclose(ours.max(0), theirs.max(0), atol=1e-5)


@pytest.mark.parametrize(
    ("shape", "extents"),
    [
        (coal.Box(0.1, 0.2, 0.3), [0.1, 0.2, 0.3]),
        (coal.Sphere(0.1), [0.2, 0.2, 0.2]),
        (coal.Ellipsoid(0.1, 0.2, 0.3), [0.2, 0.4, 0.6]),
        (coal.Cylinder(0.1, 0.5), [0.2, 0.2, 0.5]),
        (coal.Cone(0.1, 0.5), [0.2, 0.2, 0.5]),
        (coal.Capsule(0.1, 0.5), [0.2, 0.2, 0.7]),
    ],
)
def test_primitives_have_their_sizes_and_centres(shape, extents):
    ((drawn, _),) = shapes_of(geometry_object(shape))
    np.testing.assert_allclose(drawn.extents, extents, atol=0.006)
    np.testing.assert_allclose(drawn.bounds.mean(axis=0), [1.0, 0.0, 0.0], atol=1e-9)


def test_unbounded_shapes_are_not_drawn():
    assert shapes_of(geometry_object(coal.Halfspace())) == []


def test_edges_of_a_box_are_sharp():
    box = creased(creation.box())
    assert len(box.vertices) == 24
    assert np.allclose(np.abs(box.vertex_normals).max(axis=1), 1.0)
    normals = box.vertex_normals[box.faces]
    assert (np.einsum("ij,ikj->ik", box.face_normals, normals) > 0.99).all()


def test_a_sphere_is_smooth():
    ball = sphere(segments=40)
    drawn = creased(ball)
    assert len(drawn.vertices) == len(ball.vertices)
    assert np.einsum("ij,ij->i", drawn.vertex_normals, drawn.vertices).min() > 0.97


def test_degenerate_faces_are_left_out():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]])
    drawn = creased(Trimesh(points, [(0, 1, 2), (0, 1, 3), (0, 0, 1)], process=False))
    assert len(drawn.faces) == 1
    np.testing.assert_allclose(np.linalg.norm(drawn.vertex_normals, axis=1), 1.0)


def test_terrain_boxes_point_outwards():
    boxes = np.array([[1.0, 2, 3, 0.5, 0.4, 0.3], [0, 0, 0, 1, 1, 1]])
    terrain = box_mesh(checked_boxes(boxes))
    assert terrain.volume == pytest.approx(8.0 * boxes[:, 3:].prod(axis=1).sum())
    np.testing.assert_allclose(terrain.vertices[:8].max(0), [1.5, 2.4, 3.3])


def test_the_ellipsoid_has_the_inertia_that_it_represents():
    radii = np.array([0.3, 0.2, 0.1])
    moments = 0.2 * (radii @ radii - radii**2)
    shape = ellipsoid(pin.Inertia(1.0, np.array([0.1, 0, 0]), np.diag(moments)))
    np.testing.assert_allclose(shape.center_mass, [0.1, 0, 0], atol=1e-9)
    inertia = shape.moment_inertia / shape.volume
    np.testing.assert_allclose(inertia, np.diag(moments), rtol=0.05, atol=1e-9)


def without(tmp_path, *tags):
    text = wbc.load("simple_humanoid").urdf_path.read_text()
    for tag in tags:
        text = re.sub(rf"<{tag}.*?</{tag}>", "", text, flags=re.S)
    path = tmp_path / "bare.urdf"
    path.write_text(text)
    return path


def test_a_robot_without_visuals_is_drawn_from_its_collision_shapes(tmp_path):
    feet = {"left_foot": "left_foot", "right_foot": "right_foot"}
    visuals = visuals_of(wbc.load(without(tmp_path, "visual"), **feet))
    assert "collision" in visuals.source
    assert len(visuals.shapes) > 10


def test_a_robot_without_any_shapes_is_drawn_from_its_inertias():
    robot = wbc.load("simple_humanoid")
    vars(robot).update(visual_model=pin.GeometryModel(), collision_model=pin.GeometryModel())
    visuals = visuals_of(robot)
    assert visuals.source == "drawn from its inertias"
    heavy = [j for j in range(1, robot.model.njoints) if robot.model.inertias[j].mass > 0.1]
    assert all(visuals.shapes[j] for j in heavy)


@pytest.mark.parametrize("name", ["talos", "g1", "romeo", "icub", "simple_humanoid"])
def test_every_known_robot_shows_its_visual_shapes(name):
    robot = wbc.load(name)
    visuals = visuals_of(robot)
    assert visuals.source == ""
    assert sum(map(len, visuals.shapes.values())) >= len(robot.visual_model.geometryObjects)
    assert 1.2 * robot.com_height < visuals.top < 3.0 * robot.com_height
