"""One-file page of a run: opens from a mail, without a server and without a network."""

from __future__ import annotations

import base64
import functools
import hashlib
import json
from importlib.resources import files
from typing import Any

from jinja2 import Environment

from setcmas_tools.pages.page import rendered, templates
from setcmas_tools.replay.history import RunHistory
from setcmas_tools.report.calls import calls_entry
from setcmas_tools.report.charts import charts_entry
from setcmas_tools.report.facts import facts_of
from setcmas_tools.report.listing import listings
from setcmas_tools.report.motion import common_times, fleet_entry
from setcmas_tools.report.packing import SCALE
from setcmas_tools.report.pair import Pair
from setcmas_tools.report.pictures import embedded_pictures
from setcmas_tools.report.plane import plane_entry
from setcmas_tools.run.run import Run

_SCRIPTS = ('plane.js', 'player.js')


def report_page(pair: Pair) -> str:
    """Return the page of a run, or of a run beside another one."""
    script = _player()
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode('ascii')
    metrics, remarks = pair.metrics('html')
    return rendered(
        _templates(),
        'report.html',
        title=pair.run.title,
        pair=pair,
        facts=facts_of(pair.run),
        other=facts_of(pair.other) if pair.other else None,
        metrics=metrics,
        remarks=remarks,
        pictures=list(embedded_pictures(pair)),
        listings=listings(pair.run),
        data=_data(pair.run, pair.other),
        script=script,
        script_hash=f'sha256-{digest}',
    )


@functools.cache
def _templates() -> Environment:
    return templates(__package__)


def _player() -> str:
    folder = files(__package__) / 'templates'
    return ''.join((folder / name).read_text(encoding='utf-8') for name in _SCRIPTS)


def _data(run: Run, other: Run | None) -> str:
    """Return what the player shows, as JSON that ends no element of a page."""
    history = RunHistory(run)
    t = common_times(history)
    content: dict[str, Any] = {
        'scale': SCALE,
        't': t.tolist(),
        'robots': fleet_entry(history, t),
        'others': fleet_entry(RunHistory(other), t) if other else [],
        'calls': calls_entry(history),
        'plane': plane_entry(history),
        'charts': charts_entry(run, other, t),
    }
    text = json.dumps(content, separators=(',', ':'), allow_nan=False)
    for letter in '<>&':
        text = text.replace(letter, f'\\u{ord(letter):04x}')
    return text
