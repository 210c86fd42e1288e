"""The HTML of a page: one document that holds its style, its script and its data."""

from __future__ import annotations

import base64
import functools
import hashlib
import html
import json
import math
import re
from collections.abc import Mapping, Sequence
from importlib.resources import files
from string import Template
from typing import Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.palettes import is_bright, plot_colour, plot_hex
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.robots.models_by_name import shape_of, symbol

MODULES = (
    'history.js', 'canvas.js', 'camera.js', 'plane.js', 'charts.js', 'robots.js', 'player.js',
    'live.js', 'main.js',
)  # fmt: skip
"""Each imports from those before it only."""
_IMPORT = re.compile(r'^import .*?;\n', re.MULTILINE | re.DOTALL)
_EXPORT = re.compile(r'^export ', re.MULTILINE)
_CONTROL = re.compile(r'[\x00-\x08\x0b-\x1f\x7f-\x9f]')


def document(title: str, body: str, content: Mapping[str, Any]) -> str:
    """Return a page that needs nothing but itself, without control characters.

    Args:
        title: Of its window.
        body: HTML, in which texts are escaped.
        content: What its scripts draw, as `page_content` has it.
    """
    script = page_script()
    connects = "; connect-src 'self'" if content['live'] else ''
    text = Template(template('page.html')).substitute(
        title=escaped(title),
        policy=f"script-src 'sha256-{digest(script)}'{connects}",
        style=template('base.css') + template('style.css'),
        body=body,
        data=json_data(content),
        script=script,
    )
    return _CONTROL.sub('\N{REPLACEMENT CHARACTER}', text)


@functools.cache
def page_script() -> str:
    """Return the page's modules as one, which a file that is opened by itself can hold."""
    return ''.join(_EXPORT.sub('', _IMPORT.sub('', template(name))) for name in MODULES)


def element(tag: str, text: object, kind: str = '') -> str:
    """Return an element that holds a text."""
    own = f' class="{kind}"' if kind else ''
    return f'<{tag}{own}>{escaped(text)}</{tag}>'


def escaped(text: object) -> str:
    """Return a text that no browser takes for HTML."""
    return html.escape(str(text))


@functools.cache
def template(name: str) -> str:
    """Return the text of a file of the page."""
    return (files(__package__) / 'templates' / name).read_text(encoding='utf-8')


def digest(script: str) -> str:
    """Return the digest by which a policy allows a script."""
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode('ascii')


def json_data(content: Mapping[str, Any]) -> str:
    """Return JSON that ends no element of a page."""
    text = json.dumps(content, separators=(',', ':'), allow_nan=False)
    for letter in '<>&':
        text = text.replace(letter, f'\\u{ord(letter):04x}')
    return text


def page_content(**known: Any) -> dict[str, Any]:
    """Return the content of a page; parts that are not given are empty."""
    plane: dict[str, Any] = {
        **dict.fromkeys(('arena', 'links')),
        **{name: [] for name in ('discs', 'polygons', 'references', 'drawings')},
        'sent': {},
    }
    empty: dict[str, Any] = {
        **{name: [] for name in ('t', 'robots', 'charts')},
        **{'calls': {}, 'plane': plane, 'live': None},
    }
    return empty | known


@functools.lru_cache(4096)
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


def rounded(values: Floats | Sequence[float]) -> list[float | None]:
    """Return numbers in m, rad or s to four decimals; None for those that are not finite."""
    numbers = np.asarray(values, dtype=float)
    return [round(one, 4) if math.isfinite(one) else None for one in numbers.tolist()]


def changes(values: Sequence[object]) -> list[tuple[int, object]]:
    """Return the changes of a column that seldom changes: index and new value of each."""
    return [
        (place, value)
        for place, value in enumerate(values)
        if not place or value != values[place - 1]
    ]
