"""Descriptions whose meshes are found without their packages."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
import pytest
from robottools import changed

import wbc
from wbc.robot.collision_shapes import collision_shapes
from wbc.robot.packages import with_file_addresses


def test_addresses_of_meshes_become_files_that_exist():
    robot = wbc.load("talos")
    text = robot.urdf_path.read_text("utf-8")
    found = with_file_addresses(text, robot.urdf_path, robot.package_dirs)
    addresses = re.findall(r'<mesh[^>]*filename="([^"]+)"', found)
    assert len(addresses) > 20
    assert all(Path(address.removeprefix("file://")).is_file() for address in addresses)
    assert re.sub('"file://[^"]*"', "", found) == re.sub('"package://[^"]*"', "", text)


def test_address_of_a_mesh_that_does_not_exist_stays(tmp_path):
    text = '<mesh filename="package://nowhere/a.stl"/>'
    assert with_file_addresses(text, tmp_path / "x.urdf", ()) == text


def test_a_mesh_that_was_changed_is_read_again(tmp_path):
    mesh, box = tmp_path / "trunk.stl", '<collision><origin xyz="0 0 0.23"/><geometry><box '
    path = changed(
        tmp_path, (f'{box}size="0.18 0.32 0.44"/>', f'{box[:-5]}<mesh filename="{mesh}"/>')
    )
    widths = []
    for second, width in enumerate((0.3, 0.5)):
        write_tetrahedron(mesh, width)
        os.utime(mesh, (second, second))
        (hull,) = (one for one in collision_shapes(wbc.load(path)) if one.link == "torso")
        widths.append(float(np.ptp(hull.vertices[:, 0])))
    assert widths == pytest.approx([0.3, 0.5])


def write_tetrahedron(path: Path, width: float) -> None:
    """Write a mesh that extends by `width` (m) along each axis."""
    corners = [(0.0, 0.0, 0.0), (width, 0.0, 0.0), (0.0, width, 0.0), (0.0, 0.0, width)]
    lines = ["solid tetrahedron"]
    for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)):
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex {} {} {}".format(*corners[k]) for k in face]
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid tetrahedron"]))
