"""Robots look like their meshes; without any they are still seen."""

import re

import numpy as np
import pinocchio as pin
import pytest

import wbc
from wbc.view.collada import read_collada
from wbc.view.shading import creased
from wbc.view.shapes import capsule
from wbc.view.terrain import box_mesh
from wbc.view.visuals import ellipsoid, visuals_of

CUBE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
 <asset><unit meter="0.01" name="cm"/><up_axis>Y_UP</up_axis></asset>
 <library_effects><effect id="red-fx"><profile_COMMON><technique sid="c"><phong>
  <diffuse><color>0.9 0.1 0.2 1</color></diffuse></phong></technique></profile_COMMON></effect>
 </library_effects>
 <library_materials><material id="red"><instance_effect url="#red-fx"/></material>
 </library_materials>
 <library_geometries><geometry id="quad"><mesh>
  <source id="pos"><float_array id="a" count="12">0 0 0 10 0 0 10 10 0 0 10 0</float_array></source>
  <source id="nor"><float_array id="n" count="3">0 0 1</float_array></source>
  <vertices id="ver"><input semantic="POSITION" source="#pos"/></vertices>
  <polylist material="M" count="1">
   <input semantic="VERTEX" source="#ver" offset="0"/>
   <input semantic="NORMAL" source="#nor" offset="1"/>
   <vcount>4</vcount><p>0 0 1 0 2 0 3 0</p></polylist>
 </mesh></geometry></library_geometries>
 <library_visual_scenes><visual_scene id="s"><node id="outer">
  <translate>100 0 0</translate><rotate>0 0 1 90</rotate>
  <node id="inner"><scale>2 2 2</scale><instance_geometry url="#quad"><bind_material>
   <technique_common><instance_material symbol="M" target="#red"/></technique_common>
  </bind_material></instance_geometry></node></node></visual_scene></library_visual_scenes>
</COLLADA>"""


def test_collada_keeps_placements_units_and_colours(tmp_path):
    path = tmp_path / "quad.dae"
    path.write_text(CUBE)
    (part,) = read_collada(path)
    assert part.colour == (0.9, 0.1, 0.2, 1.0)
    assert part.faces.shape == (2, 3)
    # 10 cm twice as large, turned by 90° about z, 1 m along x.
    np.testing.assert_allclose(part.vertices.min(0), [0.8, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(part.vertices.max(0), [1.0, 0.2, 0.0], atol=1e-12)


@pytest.mark.parametrize("text", ["no xml", "<COLLADA/>", CUBE.replace("#quad", "#none")])
def test_an_invalid_collada_file_is_refused(tmp_path, text):
    path = tmp_path / "broken.dae"
    path.write_text(text)
    with pytest.raises(ValueError, match=r".+"):
        read_collada(path)


@pytest.mark.parametrize("name", ["romeo", "icub"])
def test_collada_meshes_have_the_same_extent_as_pinocchios(name):
    robot = wbc.load(name)
    for thing in robot.visual_model.geometryObjects:
        parts = read_collada(thing.meshPath)
        ours = np.concatenate([part.vertices for part in parts]) * thing.meshScale.reshape(3)
        theirs = thing.geometry.vertices()
        np.testing.assert_allclose(ours.min(0), theirs.min(0), atol=1e-5)
        np.testing.assert_allclose(ours.max(0), theirs.max(0), atol=1e-5)


def test_edges_of_a_box_stay_sharp():
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))])
    vertices, index, normals = creased(corners, faces)
    assert len(vertices) == 24
    assert np.allclose(np.abs(normals).max(axis=1), 1.0)
    a, b, c = (vertices[index[:, k]] for k in range(3))
    flat = np.cross(b - a, c - a)
    assert np.all(np.einsum("ij,ij->i", flat, normals[index[:, 0]]) > 0.99)


def test_faces_of_a_sphere_are_shaded_smoothly():
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 40, endpoint=False), np.linspace(0.1, 3.0, 20))
    points = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], -1).reshape(-1, 3)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(40), np.arange(19)))
    a, b, c, d = j * 40 + i, j * 40 + (i + 1) % 40, (j + 1) * 40 + (i + 1) % 40, (j + 1) * 40 + i
    faces = np.concatenate([np.stack([a, d, b], 1), np.stack([b, d, c], 1)])
    vertices, _, normals = creased(points, faces)
    assert len(vertices) == len(points)
    assert np.einsum("ij,ij->i", normals, vertices).min() > 0.97


def test_degenerate_faces_get_finite_normals():
    rim = np.array([[np.cos(t), np.sin(t), 0.0] for t in np.linspace(0, 6.2, 200)])
    points = np.concatenate([rim, [[0, 0, 1.0]]])
    faces = np.array([(k, k + 1, 200) for k in range(199)] + [(0, 0, 1)])
    _, index, normals = creased(points, faces)
    assert len(index) == 199
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)


def test_terrain_boxes_point_outwards():
    boxes = np.array([[1.0, 2, 3, 0.5, 0.4, 0.3], [0, 0, 0, 1, 1, 1]])
    vertices, faces, normals = box_mesh(boxes)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    outward = np.cross(b - a, c - a)
    assert np.all(np.einsum("ij,ij->i", outward, normals[faces[:, 0]]) > 0)
    np.testing.assert_allclose(vertices[:24].max(0), [1.5, 2.4, 3.3])


def test_ellipsoid_of_a_link_has_the_links_inertia():
    radii = np.array([0.3, 0.2, 0.1])
    moments = 0.2 * (radii @ radii - radii**2)
    inertia = pin.Inertia(1.0, np.array([0.1, 0, 0]), np.diag(moments))
    (body,) = ellipsoid(inertia)
    matrix = np.array(body["object"]["matrix"]).reshape(4, 4).T
    np.testing.assert_allclose(np.sort(np.linalg.norm(matrix[:3, :3], axis=0)), np.sort(radii))
    np.testing.assert_allclose(matrix[:3, 3], [0.1, 0, 0])
    assert np.linalg.det(matrix[:3, :3]) > 0


def test_a_capsule_has_its_length_and_radius():
    position = capsule(0.1, 0.5)["data"]["attributes"]["position"]["array"]
    points = np.frombuffer(position.data, dtype="<f4").reshape(-1, 3)
    np.testing.assert_allclose(np.ptp(points, axis=0), [0.2, 0.2, 0.7], atol=0.003)


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
