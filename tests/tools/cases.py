"""Cases of parametrized tests."""

from __future__ import annotations

import pytest


def slow(*values: object) -> object:
    """A case that runs with the slow tests: a like one is among the others."""
    return pytest.param(*values, marks=pytest.mark.slow)
