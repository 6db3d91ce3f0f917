"""Descriptions whose meshes are found without their packages."""

from __future__ import annotations

import re
from pathlib import Path

import wbc
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
