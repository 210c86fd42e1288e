"""Topics that the nodes publish: names, types and latching as the code has them.

Every call of `create_publisher` must be told of in topics.yaml, and nothing else may be.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import Any

import yaml

from setcmas_simu.fleet import topics

ROOT = Path(__file__).parents[2]
PACKAGES = ('setcmas_simu', 'setcmas_ctrl', 'setcmas_expe', 'setcmas_tools')
WORDS = Path(__file__).with_name('topics.yaml')


def text() -> str:
    """Return the table of topics, and that of experiments.

    Raises:
        ValueError: A publisher is not told of, or something is told of that nobody publishes.
    """
    words = yaml.safe_load(WORDS.read_text())
    calls = publishers()
    told = {key for section in words.values() for key in section}
    if astray := told ^ calls.keys():
        raise ValueError(f'{WORDS.name} and the publishers of the code differ in {astray}')
    return '\n\n'.join(
        [
            _table(words['simulation'], calls),
            '## Also in experiments',
            _table(words['experiment'], calls),
        ]
    )


def publishers() -> dict[str, tuple[str, bool]]:
    """Return type and latching of each publisher in the code, by module and spelling of its topic.

    The type is '' where the call does not name it.
    """
    found = {}
    for package in PACKAGES:
        for path in sorted((ROOT / package / package).rglob('*.py')):
            module = '.'.join(path.relative_to(ROOT / package).with_suffix('').parts)
            tree = ast.parse(path.read_text())
            types = _message_types(tree)
            for call in ast.walk(tree):
                if isinstance(call, ast.Call) and _creates_publisher(call.func):
                    arguments = [ast.unparse(argument) for argument in call.args]
                    topic = arguments[1] if len(arguments) == 3 else 'args'
                    kind = types.get(arguments[0], '')
                    found[f'{module} {topic}'] = (kind, arguments[-1] == 'qos.LATCHED')
    return found


def _creates_publisher(function: ast.expr) -> bool:
    return isinstance(function, ast.Attribute) and function.attr == 'create_publisher'


def _message_types(tree: ast.Module) -> dict[str, str]:
    """Return the full type, such as nav_msgs/Odometry, of each message class that is imported."""
    return {
        alias.name: f'{(node.module or "").removesuffix(".msg")}/{alias.name}'
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and (node.module or '').endswith('.msg')
        for alias in node.names
    }


def _table(section: dict[str, Any], calls: dict[str, tuple[str, bool]]) -> str:
    lines = ['| topic | type | rate | published by |', '|---|---|---|---|']
    for key, words in section.items():
        kind, latched = calls[key]
        topic = words.get('topic') or full_name(key.partition(' ')[2])
        rate = re.sub(r'\{([\w.]+)\.(\w+)\}', _number, words['rate'])
        told_type = words.get('type', kind) + (', latched' if latched else '')
        lines.append(f'| `{topic}` | {told_type} | {rate} | {words["by"]} |')
    return '\n'.join(lines)


def full_name(spelling: str) -> str:
    """Return the topic that code such as `topics.ODOM` or `topics.mocap_topic(robot)` names."""
    if function := re.match(r'topics\.(mocap_topic|truth_topic)\(', spelling):
        return str(getattr(topics, function[1])(1)).replace(topics.robot_name(1), 'tb3_i')
    constants = re.findall(r'\b[A-Z][A-Z_]+\b', spelling)
    name = str(getattr(topics, constants[-1]))
    return name if name.startswith('/') else f'/tb3_i/{name}'


def _number(found: re.Match[str]) -> str:
    """Return a number in a module, read and not imported: the site needs no ROS."""
    module, name = found.groups()
    path = ROOT / module.partition('.')[0] / f'{module.replace(".", "/")}.py'
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == name:
            return f'{ast.literal_eval(node.value):g}'
    raise ValueError(f'{module} has no {name}')
