"""The HTML of a page: one document that holds its style, its script and its data."""

from __future__ import annotations

import base64
import functools
import hashlib
import html
import json
import re
from collections.abc import Iterable, Mapping
from importlib.resources import files
from string import Template
from typing import Any

_MODULES = (
    'history.js', 'canvas.js', 'camera.js', 'plane.js', 'charts.js', 'robots.js', 'player.js',
    'live.js', 'main.js',
)  # fmt: skip
"""Each imports from those before it only."""
_IMPORT = re.compile(r'^import .*?;\n', re.MULTILINE | re.DOTALL)
_EXPORT = re.compile(r'^export ', re.MULTILINE)
_CONTROL = re.compile(r'[\x00-\x08\x0b-\x1f\x7f-\x9f]')


def document(title: str, body: Iterable[str], content: Mapping[str, Any]) -> str:
    """Return a page that needs nothing but itself, without control characters.

    Args:
        title: Of its window.
        body: HTML, from `content` and run in the functions below.
        content: What its scripts draw, as `content.page_content` has it.
    """
    script = page_script()
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode('ascii')
    connects = "; connect-src 'self'" if content['live'] else ''
    text = Template(_file('page.html')).substitute(
        title=escaped(title),
        policy=f"script-src 'sha256-{digest}'{connects}",
        style=_file('base.css') + _file('style.css'),
        body='\n'.join(body),
        data=_json(content),
        script=script,
    )
    return _CONTROL.sub('\N{REPLACEMENT CHARACTER}', text)


@functools.cache
def page_script() -> str:
    """Return the page's modules as one, which a file that is opened by itself can hold."""
    return ''.join(_EXPORT.sub('', _IMPORT.sub('', _file(name))) for name in _MODULES)


def stage(options: Iterable[str], notes: str = '', has_commands: bool = False) -> str:
    """Return the part of a page with the plane, the time bar, the table and the charts.

    Args:
        options: Checkboxes, in addition to those for trails and sizes.
        notes: HTML below the charts.
        has_commands: Whether it has buttons that command the robots.
    """
    commands = _file('commands.html') if has_commands else ''
    return Template(_file('stage.html')).substitute(
        options='\n'.join(options), notes=notes, commands=commands
    )


def checkbox(name: str, label: str) -> str:
    """Return a checked box of the stage."""
    return f'<label><input type="checkbox" id="{name}" checked> {escaped(label)}</label>'


def element(tag: str, text: object, kind: str = '') -> str:
    """Return an element that holds a text."""
    own = f' class="{kind}"' if kind else ''
    return f'<{tag}{own}>{escaped(text)}</{tag}>'


def escaped(text: object) -> str:
    """Return a text that no browser takes for HTML."""
    return html.escape(str(text))


@functools.cache
def _file(name: str) -> str:
    return (files(__package__) / 'templates' / name).read_text(encoding='utf-8')


def _json(content: Mapping[str, Any]) -> str:
    """Return JSON that ends no element of a page."""
    text = json.dumps(content, separators=(',', ':'), allow_nan=False)
    for letter in '<>&':
        text = text.replace(letter, f'\\u{ord(letter):04x}')
    return text
