"""Tasks that have a share of their weight for a while get the usual one back."""

import numpy as np

import wbc
from wbc.walking.weight_share import WeightShare


def test_a_share_of_the_weight_is_given_back_but_for_a_weight_that_was_set_meanwhile():
    first, second = wbc.ComTask(weight=20.0), wbc.AngularMomentumTask(weight=3.0)
    share = WeightShare((first, second))
    share.set(6.0)
    share.set(6.0)
    np.testing.assert_allclose(first.weight, 120.0)
    share.set(0.5)
    np.testing.assert_allclose(first.weight, 10.0)
    np.testing.assert_allclose(second.weight, 1.5)
    first.weight = 7.0
    share.set(1.0)
    np.testing.assert_allclose(first.weight, 7.0)
    np.testing.assert_allclose(second.weight, 3.0)


def test_each_row_may_have_a_share_of_its_own():
    task = wbc.ComTask(weight=20.0)
    share = WeightShare((task,))
    share.set((3.0, 3.0, 0.0))
    np.testing.assert_allclose(task.weight, (60.0, 60.0, 0.0))
    share.set(0.5)
    np.testing.assert_allclose(task.weight, 10.0)
    share.set(1.0)
    np.testing.assert_allclose(task.weight, 20.0)
