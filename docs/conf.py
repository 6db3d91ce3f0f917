"""Configuration of the documentation site; `make docs` builds it into out/site."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import site_math  # noqa: E402

import wbc  # noqa: E402

project = "wbc"
author = "The wbc developers"
copyright = "the wbc developers, Apache-2.0"
version = release = wbc.__version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "myst_nb",
    "sphinx_copybutton",
    "site_math",
]
exclude_patterns = ["_build"]
nitpicky = False
default_role = "code"

html_theme = "furo"
html_title = "wbc"
html_math_renderer = site_math.RENDERER
html_static_path: list[str] = []

myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300

autodoc_inherit_docstrings = False
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_typehints_format = "short"
autodoc_default_options = {"members": True, "show-inheritance": True}
autoclass_content = "class"
napoleon_numpy_docstring = False
napoleon_use_ivar = True

_SECTION = re.compile(r"(Args|Attributes|Returns|Raises|Yields|Note|Example|Examples):$")
_CODE = re.compile(r"(?<!`)`([^`]+)`(?!`)")
_SPECIAL = re.compile(r"([*|\\])|(?<=\w)(_)(?!\w)")


def as_restructured_text(*event: Any) -> None:
    """Turn the docstrings' Markdown into reStructuredText, in place.

    Single backticks mark code, and an indented paragraph outside the Google sections is an
    equation or a listing that is shown as it stands.

    Args:
        event: what Sphinx passes to `autodoc-process-docstring`; the last is the list of lines.
    """
    lines: list[str] = event[-1]
    out: list[str] = []
    in_section = literal = False
    for line in lines:
        if line and not line[0].isspace():
            in_section, literal = bool(_SECTION.match(line)), False
        opens = not in_section and line.startswith("    ") and (not out or not out[-1].strip())
        if opens and not literal:
            out += ["::", ""]
            literal = True
        out.append(line if literal else _inline(line))
    lines[:] = out


def _inline(line: str) -> str:
    parts = _CODE.split(line)
    escaped = [_SPECIAL.sub(r"\\\g<0>", text) for text in parts[::2]]
    code = [f"``{text.strip()}``" for text in parts[1::2]]
    return "".join(text for pair in zip(escaped, [*code, ""], strict=True) for text in pair)


def setup(app: Any) -> None:
    # Before napoleon, which reads the sections.
    app.connect("autodoc-process-docstring", as_restructured_text, priority=100)
