"""Bodies that other presets of motion capture would hear."""

from __future__ import annotations

import re
from collections.abc import Iterable

from setcmas_expe.doctor.findings import NOTE, Finding
from setcmas_expe.mocap.sources import MOCAP_SOURCES, NAME, MocapSource

Graph = Iterable[tuple[str, list[str]]]


def other_presets(graph: Graph, preset: str) -> list[Finding]:
    """Return which presets but the lab's fit topics that are there, and bodies where they tell.

    Args:
        graph: Each topic with its types.
        preset: That of the lab file.
    """
    graph = list(graph)
    heard: dict[str, list[str]] = {}
    for name, source in MOCAP_SOURCES.usable(lambda _: None).items():
        if name != preset and (found := heard_by(source, graph)):
            heard.setdefault(found, []).append(name)
    return [
        Finding(
            NOTE,
            'motion capture',
            f'{" or ".join(names)} would hear {found}',
            'set mocap.preset in the lab file, or --mocap',
        )
        for found, names in heard.items()
    ]


def heard_by(source: MocapSource, graph: Graph) -> str:
    """Return what a source would hear, in words; empty if nothing."""
    topics = [topic for topic, types in graph if source.message_type in types]
    if not source.per_body:
        return f'{source.topic}, with all bodies' if source.topic in topics else ''
    first, *again = source.topic.split(NAME)
    body = '([A-Za-z][A-Za-z0-9_]*)'
    form = re.escape(first) + body + '\\1'.join(map(re.escape, again))
    found = (re.fullmatch(form, topic) for topic in topics)
    return ', '.join(sorted(match[1] for match in found if match))
