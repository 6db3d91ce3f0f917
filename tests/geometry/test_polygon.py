"""Convex polygons: hull, area, nearest point, inscribed rectangle."""

from __future__ import annotations

import cmath
import math

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from wbc.geometry.planar import Placement, planar_rotation
from wbc.geometry.polygon import (
    clamp_to_polygon,
    convex_hull,
    is_near_segment,
    polygon_area,
    sole_corners,
)
from wbc.geometry.rectangle import inscribed_rectangle

coordinates = st.floats(-1.0, 1.0)
angles = st.floats(-math.pi, math.pi)
points = st.builds(complex, coordinates, coordinates)
#: On a grid, as vertices of meshes are: distinct points are not closer than 1 nm.
clouds = st.lists(
    st.builds(lambda x, y: complex(round(x, 9), round(y, 9)), coordinates, coordinates),
    min_size=3,
    max_size=40,
)


@given(clouds)
@settings(max_examples=60)
def test_the_corners_of_a_hull_are_among_the_points(cloud: list[complex]) -> None:
    assert set(convex_hull(cloud)) <= set(cloud)


@given(st.lists(points, min_size=3, max_size=12, unique=True))
def test_convex_hull_holds_all_its_points(cloud: list[complex]) -> None:
    hull = convex_hull(cloud)
    if len(hull) < 3:
        return  # all on one line
    for p in cloud:
        assert abs(clamp_to_polygon(p, hull, 0.0) - p) < 1e-9


@given(points, angles, points)
def test_clamped_point_lies_within_the_margin_and_is_nearest(
    centre: complex, yaw: float, p: complex
) -> None:
    polygon = sole_corners(Placement(centre, yaw), 0.1, 0.06)
    clamped = clamp_to_polygon(p, polygon, 0.02)
    local = (clamped - centre) * planar_rotation(-yaw)
    gap = math.hypot(max(abs(local.real) - 0.1, 0.0), max(abs(local.imag) - 0.06, 0.0))
    assert gap <= 0.02 + 1e-9
    if clamped != p:
        assert gap == pytest.approx(0.02, abs=1e-9)
    assert clamp_to_polygon(centre, polygon, 0.0) == centre


@given(points, points, angles, angles, points, st.floats(0.0, 1.0))
def test_points_near_the_line_between_two_soles_are_in_their_polygon(
    left: complex, right: complex, left_yaw: float, right_yaw: float, off: complex, along: float
) -> None:
    margin = 0.02
    p = left + along * (right - left) + 0.05 * off
    soles = [sole_corners(Placement(left, left_yaw), 0.1, 0.06)]
    soles.append(sole_corners(Placement(right, right_yaw), 0.1, 0.06))
    if is_near_segment(p, left, right, 0.06 + margin):
        hull = convex_hull([*soles[0], *soles[1]])
        assert abs(clamp_to_polygon(p, hull, margin) - p) < 1e-9
    assert is_near_segment(p, left, right, 0.05 * abs(off) + 1e-9)
    assert not is_near_segment(left + 0.08001j, left, left, 0.06 + margin)


@given(clouds)
@settings(max_examples=60)
def test_inscribed_rectangle_lies_in_the_hull(cloud: list[complex]) -> None:
    hull = convex_hull(set(cloud))
    assume(len(hull) >= 3)
    x0, x1, y0, y1 = inscribed_rectangle(hull)
    assert x0 <= x1
    assert y0 <= y1
    for corner in (complex(x, y) for x in (x0, x1) for y in (y0, y1)):
        assert abs(clamp_to_polygon(corner, hull, 0.0) - corner) < 1e-6


def test_inscribed_rectangle_is_the_largest() -> None:
    assert inscribed_rectangle([0j, 2 + 0j, 2 + 1j, 1j]) == pytest.approx((0, 2, 0, 1))
    # In a triangle the best rectangle on the base has half of its area.
    x0, x1, y0, y1 = inscribed_rectangle([0j, 1 + 0j, 0.5 + 1j])
    assert (x1 - x0) * (y1 - y0) == pytest.approx(0.25, rel=1e-3)
    # In a disc it is the square.
    disc = [cmath.exp(2j * math.pi * k / 200) for k in range(200)]
    x0, x1, y0, y1 = inscribed_rectangle(disc)
    assert (x1 - x0) * (y1 - y0) == pytest.approx(2.0, rel=2e-3)


def test_collinear_points_have_neither_rectangle_nor_area() -> None:
    hull = convex_hull([0j, 1 + 1j, 2 + 2j])
    x0, x1, y0, y1 = inscribed_rectangle(hull)
    assert (x1 - x0, y1 - y0) == (0, 0)
    assert polygon_area(hull) == 0.0


def test_the_area_of_a_rotated_rectangle_is_the_product_of_its_sides() -> None:
    corners = sole_corners(Placement(0.3 - 0.2j, 0.7), 0.1, 0.05)
    assert polygon_area(corners) == pytest.approx(0.02)
