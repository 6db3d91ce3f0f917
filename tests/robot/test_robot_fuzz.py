"""Damaged descriptions: whatever is deleted or overwritten, only the library's own errors come."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pinocchio as pin
from hypothesis import given, settings
from hypothesis import strategies as st
from robottools import SIMPLE

import wbc.robot
from wbc.errors import WbcError

VALUES = ("", "0", "-1", "nan", "1e400", "abc", "0 0 0", "1e9", "fixed", "base_link", "1e-12")
ELEMENTS = len(list(ET.parse(SIMPLE).getroot().iter())) - 1


@st.composite
def damaged(draw):
    """Our URDF with one to three elements or attributes removed or overwritten."""
    root = ET.parse(SIMPLE).getroot()
    for _ in range(draw(st.integers(1, 3))):
        pairs = [(parent, child) for parent in root.iter() for child in parent]
        parent, child = pairs[draw(st.integers(0, ELEMENTS - 1)) % len(pairs)]
        how = draw(st.sampled_from(("remove", "strip", "overwrite")))
        if how == "remove" or not child.attrib:
            parent.remove(child)
            continue
        key = draw(st.sampled_from(sorted(child.attrib)))
        if how == "strip":
            del child.attrib[key]
        else:
            child.attrib[key] = draw(st.sampled_from(VALUES))
    return ET.tostring(root, encoding="unicode")


@given(text=damaged())
@settings(max_examples=80)
def test_a_damaged_description_gives_findings_or_a_finite_robot(tmp_path, capfd, text):
    path = tmp_path / "damaged.urdf"
    path.write_text(text)
    refused = any(finding.severity == "error" for finding in wbc.robot.check_file(path))
    try:
        robot = wbc.robot.load(path)
    except WbcError:
        robot = None
    if robot is None:
        assert refused
    else:
        model, push = robot.model, np.ones(robot.nv)
        a = pin.aba(model, model.createData(), robot.q_nominal, np.zeros(robot.nv), push)
        assert np.isfinite(a).all()
        assert np.isfinite(robot.tau_max).all()
        assert robot.visual_model is not None
    # Pinocchio's readers write to the C++ standard error; nothing may reach it.
    assert capfd.readouterr().err == ""
