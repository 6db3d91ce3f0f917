"""Requirements of tests on the machine: CI must meet them, elsewhere the test is skipped."""

from __future__ import annotations

import os

import pytest

from wbc.errors import WbcError
from wbc.view.browser import find_browser


def need(condition: object, what: str) -> None:
    if not condition:
        if os.environ.get("CI"):
            pytest.fail(f"{what}; CI must have it")
        pytest.skip(what)


def need_browser() -> None:
    try:
        find_browser()
    except WbcError as error:
        need(False, str(error))
