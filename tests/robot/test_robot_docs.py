"""docs/robots.md documents exactly the keys that a data file and `load` accept."""

from __future__ import annotations

import inspect
import re
import sys

import pytest
from robottools import ROBOTS

import wbc
from wbc.robot.data_file import KEYS, SOLE_KEYS, check_values

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PAGE = (ROBOTS.parent / "docs" / "robots.md").read_text()


def test_data_file_page_lists_exactly_the_keys():
    documented = re.findall(r"^\| `(\w+)` \|", PAGE, flags=re.MULTILINE)
    assert sorted(documented) == sorted(KEYS)


def test_load_takes_every_key_but_the_urdf_and_its_docstring_explains_each():
    arguments = set(inspect.signature(wbc.load).parameters) - {"name_or_path"}
    assert arguments == set(KEYS) - {"urdf"}
    explained = set(re.findall(r"^ {4}(\w+): ", inspect.getdoc(wbc.load), flags=re.MULTILINE))
    assert arguments <= explained


@pytest.mark.parametrize("block", re.findall(r"```toml\n(.*?)```", PAGE, flags=re.DOTALL))
def test_every_example_of_the_data_file_page_loads(block):
    check_values(tomllib.loads(block), "docs/robots.md")


def test_examples_of_the_data_file_page_use_every_key():
    blocks = "".join(re.findall(r"```toml\n(.*?)```", PAGE, flags=re.DOTALL))
    used = set(re.findall(r"^\[?(\w+)", blocks, flags=re.MULTILINE))
    assert set(KEYS) - {"name"} <= used
    assert set(SOLE_KEYS) <= used
