"""The class of the virtual robots, as its module has it."""

from __future__ import annotations

import ast
from pathlib import Path

ROOT = Path(__file__).parents[2]
MODULE = ROOT / 'setcmas_simu' / 'setcmas_simu' / 'virtual_robot.py'
NAME = 'VirtualRobot'
NOT_RUN = '<!-- a piece of a file: not run by the tests -->'


def text() -> str:
    """Return the class as a piece of Python."""
    source = MODULE.read_text()
    (found,) = [
        node
        for node in ast.parse(source).body
        if isinstance(node, ast.ClassDef) and node.name == NAME
    ]
    return f'{NOT_RUN}\n\n```python\n{ast.get_source_segment(source, found)}\n```'
