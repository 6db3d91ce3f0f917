"""Formulas as SVG: the pages need no script and no network to show them."""

from __future__ import annotations

from html import escape
from typing import Any

import ziamath
from docutils import nodes

RENDERER = "svg"
SIZE = 17.0  # px


def _svg(latex: str, *, inline: bool) -> str:
    """The drawing of a formula, in the colour of the text around it."""
    formula = ziamath.Latex(latex, size=SIZE, inline=inline, color="currentColor")
    style = f"vertical-align:{formula.getyofst():.2f}px" if inline else "max-width:100%"
    picture = formula.svg().replace("<svg ", f'<svg style="{style}" ', 1)
    return f'<span role="math" aria-label="{escape(latex, quote=True)}">{picture}</span>'


def _inline(translator: Any, node: nodes.math) -> None:
    translator.body.append(_svg(node.astext(), inline=True))
    raise nodes.SkipNode


def _block(translator: Any, node: nodes.math_block) -> None:
    picture = _svg(node.astext(), inline=False)
    translator.body.append(f'<p style="text-align:center;overflow-x:auto">{picture}</p>')
    raise nodes.SkipNode


def setup(app: Any) -> dict[str, bool]:
    app.add_html_math_renderer(RENDERER, (_inline, None), (_block, None))
    return {"parallel_read_safe": True}
