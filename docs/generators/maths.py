r"""Formulas of the site as MathML: `$...$` in a page, which GitHub shows as well."""

from __future__ import annotations

import html
import re

from latex2mathml.converter import convert

_FORMULA = re.compile(
    r'<(?P<tag>span|div) class="arithmatex">\\[(\[](?P<tex>.*?)\\[)\]]</(?P=tag)>', re.DOTALL
)


def with_mathml(page: str) -> str:
    """Return a page's HTML with MathML in place of the LaTeX that arithmatex marked."""
    return _FORMULA.sub(_mathml, page)


def _mathml(found: re.Match[str]) -> str:
    tex = html.unescape(found['tex'])
    if found['tag'] == 'span':
        return str(convert(tex))
    return f'<div class="formula">{convert(tex, display="block")}</div>'
