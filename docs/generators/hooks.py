"""Hooks of MkDocs: generated parts before the build, formulas as MathML after it."""

from __future__ import annotations

import generate
import maths
from mkdocs.config.defaults import MkDocsConfig


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Put every page of the folder `extending` into the navigation."""
    pages = sorted(path.name for path in (generate.DOCS / 'extending').glob('*.md'))
    pages.sort(key=lambda name: name != 'index.md')
    for section in config.nav or ():
        if 'Extending' in section:
            section['Extending'] = [f'extending/{name}' for name in pages]
    return config


def on_pre_build(**_: object) -> None:
    """Bring the generated parts of the pages up to date."""
    generate.main()


def on_page_content(html: str, **_: object) -> str:
    """Return a page's content with its formulas as MathML."""
    return maths.with_mathml(html)
