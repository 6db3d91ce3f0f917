"""The staircase: its faces where they are declared."""

from __future__ import annotations

import numpy as np
import pytest

from wbc.errors import PlantError
from wbc.sim import Staircase


def test_stairs_go_up_by_their_risers_and_down_again_without_gaps():
    stairs = Staircase(risers=(0.1, 0.2, 0.15), tread=0.25, landing=0.8, distance=0.4)
    begin, end, height = stairs.tops.T
    np.testing.assert_allclose(height, [0.1, 0.3, 0.45, 0.3, 0.1])
    np.testing.assert_allclose(begin[1:], end[:-1])
    assert begin[0] == 0.4
    np.testing.assert_allclose(end - begin, [0.25, 0.25, 0.8, 0.25, 0.25])
    boxes = stairs.boxes()
    np.testing.assert_allclose(boxes[:, 2] + boxes[:, 5], height)
    np.testing.assert_allclose(boxes[:, 0] - boxes[:, 3], begin)
    assert (boxes[:, 2] - boxes[:, 5] < 0.0).all()


def test_footholds_are_the_middles_of_stairs_both_ends_of_a_deep_landing_and_the_floor_behind():
    stairs = Staircase(risers=(0.1, 0.2), tread=0.25, landing=0.8, distance=0.4)
    expected = [(0.525, 0.1), (0.75, 0.3), (1.35, 0.3), (1.575, 0.1), (1.8, 0.0)]
    np.testing.assert_allclose(stairs.footholds(inset=0.1), expected)
    narrow = Staircase(risers=(0.1,), tread=0.25, landing=0.3, distance=0.4)
    np.testing.assert_allclose(narrow.footholds(inset=0.1), [(0.55, 0.1), (0.8, 0.0)])


def test_invalid_stairs_are_refused():
    with pytest.raises(PlantError, match="must be positive"):
        Staircase(tread=0.0)
    with pytest.raises(PlantError, match="there must be a riser"):
        Staircase(risers=())
