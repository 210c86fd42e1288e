"""Hooks of MkDocs: generated parts before the build, formulas as MathML after it."""

from __future__ import annotations

import generate
import maths


def on_pre_build(**_: object) -> None:
    """Bring the generated parts of the pages up to date."""
    generate.main()


def on_page_content(html: str, **_: object) -> str:
    """Return a page's content with its formulas as MathML."""
    return maths.with_mathml(html)
