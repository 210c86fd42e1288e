"""CHANGELOG.rst of each ROS package, in the form of catkin and bloom, from CHANGELOG.md."""

from __future__ import annotations

import re
import textwrap
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGES = ('setcmas_simu', 'setcmas_ctrl', 'setcmas_expe', 'setcmas_tools', 'launch_scripts')


def files() -> dict[Path, str]:
    """Return the text of each file. A release is one of all packages: they differ in the title."""
    markdown = (ROOT / 'CHANGELOG.md').read_text()
    return {ROOT / package / 'CHANGELOG.rst': text(package, markdown) for package in PACKAGES}


def text(package: str, markdown: str) -> str:
    """Return the changelog of a package; the section that is not released yet is Forthcoming."""
    title = f'Changelog for package {package}'
    parts = ['\n'.join(['^' * len(title), title, '^' * len(title)])]
    for section in re.split(r'^## ', markdown, flags=re.MULTILINE)[1:]:
        head, _, body = section.partition('\n')
        version, _, day = head.partition(', ')
        body = re.sub(r'^### .*$', '', body, flags=re.MULTILINE)
        name = 'Forthcoming' if day == 'unreleased' else f'{version} ({day})'
        parts.append('\n'.join([name, '-' * len(name), *_items(body)]))
    return '\n\n'.join(parts) + '\n'


def _items(body: str) -> list[str]:
    items = re.findall(r'^- (.*?)(?=^- |\Z)', body, re.MULTILINE | re.DOTALL)
    return [_item(' '.join(item.split())) for item in items]


def _item(words: str) -> str:
    plain = re.sub(r'\[([^\]]*)\]\([^)]*\)', r'\1', words)  # links lead nowhere from there
    pieces = [
        f'``{piece}``' if index % 2 else re.sub(r'([\\*_|])', r'\\\1', piece)
        for index, piece in enumerate(plain.split('`'))
    ]
    wrapped = textwrap.wrap(''.join(pieces), 97, break_long_words=False, break_on_hyphens=False)
    return textwrap.indent('\n'.join(wrapped), '  ').replace('  ', '* ', 1)
