"""Hooks of MkDocs: generated parts before the build; formulas as MathML and "Try it" after it."""

from __future__ import annotations

import re
from pathlib import Path

import generate
import maths
import notebook_page
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

from setcmas_tools.page.site_folder import site

TRY = 'try/index.html'
"""The page that runs laws, in the built site."""

_TRIED = {
    'index.md': (r'(?=<table>)', 'Try it in your browser', ''),
    'atlas.md': (r'(?=<p><code>(\w+)</code>: )', 'Try it', '#law='),
    'exercises.md': (r'<h3 id="(\w+)">.*?</h3>', 'Try it', '#exercise='),
}
"""By page: where links to the page that runs laws are put, their text, and how fragments begin."""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Take generated pages from the code, whatever the committed ones are, and run notebooks."""
    pages = generate.generated_files()
    for notebook in sorted((generate.DOCS / 'notebooks').glob('*.ipynb')):
        pages[notebook.with_suffix('.md')] = notebook_page.text(notebook)
    for path, text in pages.items():
        if generate.DOCS not in path.parents:  # beside the packages
            continue
        name = path.relative_to(generate.DOCS).as_posix()
        if old := files.get_file_from_path(name):
            files.remove(old)
        files.append(File.generated(config, name, content=text))
    return files


def on_page_content(html: str, page: Page, **_: object) -> str:
    """Return a page's content with its formulas as MathML, and links to try its laws."""
    html = maths.with_mathml(html)
    if page.file.src_uri not in _TRIED:
        return html
    place, text, start = _TRIED[page.file.src_uri]

    def linked(found: re.Match[str]) -> str:
        address = TRY + (start + found[1] if start else '')
        return f'{found[0]}<p><a class="md-button" href="{address}">{text}</a></p>'

    return re.sub(place, linked, html)


def on_post_build(config: MkDocsConfig) -> None:
    """Write the page that runs laws, whose Python comes from a content delivery network."""
    for name, content in site().items():
        path = Path(config.site_dir) / Path(TRY).parent / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
