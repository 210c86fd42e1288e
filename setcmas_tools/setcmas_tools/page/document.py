"""The HTML of a page: one document that holds its style, its script and its data, packed.

Answers of students, written in Markdown, become HTML that only shows: no scripts, no network.
"""

from __future__ import annotations

import base64
import functools
import hashlib
import html
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError, needs
from setcmas_simu.fleet.palettes import is_bright, plot_colour, plot_hex
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.robots.models_by_name import shape_of, symbol

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
        content: What its scripts draw, as `page_content` has it.
    """
    script = page_script()
    connects = "; connect-src 'self'" if content['live'] else ''
    text = Template(_file('page.html')).substitute(
        title=escaped(title),
        policy=f"script-src 'sha256-{_digest(script)}'{connects}",
        style=_file('base.css') + _file('style.css'),
        body='\n'.join(body),
        data=_json(content),
        script=script,
    )
    return _CONTROL.sub('\N{REPLACEMENT CHARACTER}', text)


def site_files(version: str, connects: str) -> dict[str, str]:
    """Return the page that runs laws, with its own modules and those of the player, by path.

    Args:
        version: Of setcmas.
        connects: Where it may get Python from, besides its own server; '' for nowhere.
    """
    site = files(__package__) / 'templates' / 'site'
    own = {one.name: one.read_text(encoding='utf-8') for one in site.iterdir()}
    fields = {
        'version': escaped(version),
        'connects': f' {connects}' if connects else '',
        'stage': stage([checkbox('links', 'links')]),
        'data': _json(page_content()),
    }
    own['index.html'] = Template(own['index.html']).substitute(fields)
    script = own.pop('sandbox.js')
    own['sandbox.html'] = Template(own['sandbox.html']).substitute(
        script=script, digest=_digest(script)
    )
    own['style.css'] = _file('base.css') + _file('style.css') + own.pop('site.css')
    del own['pyodide.json']
    return own | {f'player/{name}': _file(name) for name in _MODULES}


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


def _digest(script: str) -> str:
    """Return the digest by which a policy allows a script."""
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode('ascii')


def _json(content: Mapping[str, Any]) -> str:
    """Return JSON that ends no element of a page."""
    text = json.dumps(content, separators=(',', ':'), allow_nan=False)
    for letter in '<>&':
        text = text.replace(letter, f'\\u{ord(letter):04x}')
    return text


def answers_html(file: Path) -> str:
    """Return the HTML of a Markdown file; HTML and formulas are shown as text, images as links.

    Raises:
        SetcmasError: The file cannot be read, or a package is missing.
    """
    with needs('report'):
        from markdown_it import MarkdownIt

    markdown = MarkdownIt('commonmark', {'html': False}).enable(['table', 'strikethrough'])
    tokens = markdown.disable('image').parse(_text(file))
    for token in tokens:
        if token.type in ('heading_open', 'heading_close'):  # below the title of the page
            token.tag = f'h{min(6, int(token.tag[1:]) + 1)}'
    return str(markdown.renderer.render(tokens, markdown.options, {}))


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding='utf-8-sig')
    except OSError as error:
        raise SetcmasError(f"answers '{file}' cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise SetcmasError(f"answers '{file}' must be a text file in UTF-8") from error


SCALE = 10_000
"""Units of a packed number per m, rad or s: positions keep a tenth of a millimetre."""

Packed = list[int | None]


def page_content(**known: Any) -> dict[str, Any]:
    """Return the content of a page; parts that are not given are empty."""
    plane: dict[str, Any] = {
        **dict.fromkeys(('arena', 'links')),
        **{name: [] for name in ('discs', 'polygons', 'references', 'drawings')},
        'sent': {},
    }
    empty: dict[str, Any] = {
        **{name: [] for name in ('t', 'robots', 'others', 'charts')},
        **{'scale': SCALE, 'calls': {}, 'plane': plane, 'live': None},
    }
    return empty | known


def look_entry(robot: int, model: str, nb_robots: int) -> dict[str, Any]:
    """Return name, colour and outline of a robot, and the size in m of a unit of the outline."""
    outline = symbol(model)
    true_m = np.ptp(np.array(shape_of(model).outline), axis=0)
    return {
        'number': robot,
        'name': robot_name(robot),
        'colour': plot_hex(robot, nb_robots),
        'bright': is_bright(plot_colour(robot, nb_robots)),
        'outline': np.round(outline, 3).tolist(),
        'metres': round(float(true_m[0] / np.ptp(outline[:, 0])), 4),
    }


def colour_code(colour: Sequence[float]) -> str:
    """Return red, green and blue as a page has them; they are clipped to 0 to 1."""
    red, green, blue = (round(255 * min(max(part, 0.0), 1.0)) for part in colour)
    return f'#{red:02x}{green:02x}{blue:02x}'


def packed(values: Floats | Sequence[float]) -> Packed:
    """Return K numbers as differences from the last known one, in 1/`SCALE`; None for NaN."""
    numbers = np.asarray(values, dtype=float)
    known = np.flatnonzero(np.isfinite(numbers))
    steps = np.diff(np.round(numbers[known] * SCALE).astype(np.int64), prepend=0).tolist()
    result: Packed = [None] * len(numbers)
    for place, step in zip(known.tolist(), steps, strict=True):
        result[place] = step
    return result


def changes(values: Sequence[object]) -> list[tuple[int, object]]:
    """Return the changes of a column that seldom changes: index and new value of each."""
    return [
        (place, value)
        for place, value in enumerate(values)
        if not place or value != values[place - 1]
    ]
