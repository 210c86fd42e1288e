"""Hooks of MkDocs: generated parts before the build, formulas as MathML after it."""

from __future__ import annotations

import generate
import maths
import notebook_page
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Put every page of the folder `extending` into the navigation."""
    pages = sorted(path.name for path in (generate.DOCS / 'extending').glob('*.md'))
    pages.sort(key=lambda name: name != 'index.md')
    for section in config.nav or ():
        if 'Extending' in section:
            section['Extending'] = [f'extending/{name}' for name in pages]
    return config


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


def on_page_content(html: str, **_: object) -> str:
    """Return a page's content with its formulas as MathML."""
    return maths.with_mathml(html)
