"""Imports of the code are declared: in pyproject.toml, for each extra, and in package.xml."""

import ast
import functools
import re
import sys
from importlib.metadata import packages_distributions
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

tomllib = pytest.importorskip('tomllib')

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / 'pyproject.toml').read_text(encoding='utf-8'))['project']
PACKAGES = ('setcmas_simu', 'setcmas_ctrl', 'setcmas_expe', 'setcmas_tools', 'launch_scripts')
OWN = {*PACKAGES, 'rviz_marker', 'rviz_marker_array'}  # the latter from control scripts
distributions = functools.cache(packages_distributions)  # slow

EXTRAS = {
    'launch_scripts/launch_scripts/status_display.py': 'lab',
    'launch_scripts/launch_scripts/commands/grade.py': 'grade',
    'setcmas_ctrl/setcmas_ctrl/filter': 'filter',
    'setcmas_ctrl/setcmas_ctrl/safety_filter.py': 'filter',
    'setcmas_expe/setcmas_expe/mocap': 'camera',
    'setcmas_expe/setcmas_expe/pause/joystick.py': 'lab',
    'setcmas_tools/setcmas_tools/measures/response_fit.py': 'identify',
    'setcmas_tools/setcmas_tools/grade': 'grade',
    'setcmas_tools/setcmas_tools/page/report_file.py': 'report',
    'setcmas_tools/setcmas_tools/plots/film.py': 'test',  # ffmpeg may come from elsewhere
    'setcmas_tools/setcmas_tools/run/run.py': 'notebook',
    'setcmas_tools/setcmas_tools/study': 'study',
    'docs': 'docs',
    'tests': 'all',
}
"""Which code may import the packages of an extra."""

SYSTEM_PACKAGES = {'PIL': 'pil', 'yaml': 'yaml'}
"""Modules that are called otherwise in rosdep's keys, `python3-NAME`."""

PIP_KEYS = {
    'daqp', 'joblib', 'mcap', 'msgspec', 'rosbags',
    'websockets',
}  # fmt: skip
"""Modules that beside a sourced ROS come from PyPI; their keys are `python3-NAME-pip`."""

NODE_PACKAGE = re.compile(r"package='(\w+)'")
"""Finds what a launch file starts."""

EXTRAS_BESIDE_ROS = ('filter', 'grade', 'identify', 'lab', 'notebook', 'study')
"""Extras whose packages package.xml requires: there is no choice with rosdep."""


def files(folder):
    """Return the Python files below a folder, without students' scripts that may be wrong."""
    wrong = ROOT / 'tests/setcmas_ctrl/laws'
    return [
        path
        for path in sorted((ROOT / folder).rglob('*.py'))
        if wrong not in path.parents or path.parent == wrong
    ]


def imported(path):
    """Return the top-level modules that a file imports from outside of Python and of setcmas."""
    return _modules(path) - set(sys.stdlib_module_names) - OWN


@functools.cache
def _modules(path):
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names.add(node.module)
    return {name.partition('.')[0] for name in names}


def ours(path):
    """Return the packages of setcmas that a file imports."""
    return {name for name in _modules(path) if name in PACKAGES}


def declared(extra):
    """Return the distributions that `pip install setcmas[EXTRA]` names; '' for no extra."""
    extras = PROJECT['optional-dependencies']
    found = set()
    for requirement in extras[extra] if extra else PROJECT['dependencies']:
        name, inner = re.match(r'([\w.-]+)(?:\[(.*)\])?', requirement).groups()
        own = inner.split(',') if name == 'setcmas' else []
        found |= set().union(*map(declared, own)) if own else {name.lower()}
    return found


def undeclared(module, extras):
    names = {name.replace('_', '-').lower() for name in distributions().get(module, [module])}
    return not any(names & declared(extra) for extra in ('', *extras))


def is_ros(module):
    """Return whether a module comes with the extra `ros`, or with ROS 2 alone."""
    return module in ('launch', 'launch_ros', 'tf2_msgs') or any(
        name.startswith('ros-') for name in distributions().get(module, ())
    )


@pytest.mark.parametrize(
    'folder', [*(f'{package}/{package}' for package in PACKAGES), 'docs', 'tests']
)
def test_every_import_is_declared_in_pyproject(folder):
    pytest.importorskip('rclpy')
    near = files('docs') + files('tests')
    beside = {path.stem for path in near} | {path.parent.name for path in near}
    missing = []
    for path in files(folder):
        place = path.relative_to(ROOT).as_posix()
        extras = [extra for part, extra in EXTRAS.items() if place.startswith(part)]
        for module in imported(path):
            if folder in ('docs', 'tests') and module in beside:
                continue
            if not is_ros(module) and undeclared(module, extras):
                missing.append(f'{place} imports {module}')

    assert missing == []


def keys_of_imports(package):
    """Return what package.xml must declare: our packages, those of ROS, and keys of rosdep."""
    launched = files(f'{package}/launch')
    paths = files(f'{package}/{package}') + launched
    nodes = [name for path in launched for name in NODE_PACKAGE.findall(path.read_text())]
    keys = {name for name in nodes if name not in PACKAGES}
    keys |= {module for path in paths for module in ours(path)} - {package}
    for module in set().union(*map(imported, paths)):
        if is_ros(module):
            keys.add(module)
        elif module in PIP_KEYS:
            keys.add(f'python3-{module}-pip')
        elif not undeclared(module, EXTRAS_BESIDE_ROS):
            keys.add(f'python3-{SYSTEM_PACKAGES.get(module, module)}')
    return keys


@pytest.mark.parametrize('package', PACKAGES)
def test_package_xml_declares_what_its_package_imports_and_nothing_else(package):
    pytest.importorskip('rclpy')
    manifest = ElementTree.parse(ROOT / package / 'package.xml').getroot()
    declared_keys = [node.text for node in manifest if node.tag == 'exec_depend']
    assert sorted(declared_keys) == sorted(keys_of_imports(package))


def test_pip_keys_are_in_our_rosdep_list_as_pyproject_asks_for_them():
    keys = set()
    for package in PACKAGES:
        manifest = ElementTree.parse(ROOT / package / 'package.xml').getroot()
        keys |= {node.text for node in manifest.iter('exec_depend') if node.text.endswith('-pip')}
    rules = yaml.safe_load((ROOT / 'rosdep.yaml').read_text())
    extras = PROJECT['optional-dependencies']
    chosen = [requirement for name in EXTRAS_BESIDE_ROS for requirement in extras[name]]
    asked = [one.partition(';')[0] for one in (*PROJECT['dependencies'], *chosen)]

    assert keys == rules.keys()
    for key, rule in rules.items():
        (wanted,) = rule['ubuntu']['pip']['packages']
        name = key.removeprefix('python3-').removesuffix('-pip')
        assert wanted in asked
        assert wanted.startswith(name)
