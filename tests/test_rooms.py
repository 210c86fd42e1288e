"""The house: who imports whom, and which modules may import ROS.

A room is a folder of a package, or a module outside these folders. Imports point from the
later package to the earlier one, and rooms import each other in no circle, annotations included.
"""

import ast
import functools
import graphlib
import re
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ('setcmas_simu', 'setcmas_ctrl', 'setcmas_expe', 'setcmas_tools', 'launch_scripts')
ROS = ('rclpy', 'rcl_interfaces', 'builtin_interfaces', 'rosgraph_msgs', 'tf2_ros', 'std_srvs')

FILES, ARROWS, THIN_ARROWS = 269, 162, 13
"""Most files of the product, most pairs of folders of which one imports the other, and most of
these that rest on a single import. Lower them where the tests print that fewer are left.
"""

ADDED_FREELY = tuple(
    f'setcmas_ctrl.{room}.' for room in ('algorithms', 'conditions', 'exercises', 'sessions')
)
"""Files that users or lecturers may add, too, which do not count."""

MAY_IMPORT_ROS = {
    'setcmas_ctrl': (
        'controller event_triggered_comm fleet_poses fleet_network pause_watch '
        'safety_filter_node si_to_uni_node'
    ),
    'setcmas_ctrl.controllers': (
        'fleet_monitor fleet_readiness fleet_scripts fleet_time graph_watch markers'
    ),
    'setcmas_expe.lab': 'lab_examination',
    'setcmas_expe.emulation': 'emulated_lab emulated_turtlebot3 faults',
    'setcmas_expe.guard': 'guard_node guard_watch motor_power',
    'setcmas_expe.mocap': 'camera_node receiver',
    'setcmas_expe.pause': 'bridge_watch joystick pause_node',
    'setcmas_expe': 'bridges cmd_vel_bridge mocap_bridge',
    'setcmas_simu': 'simulator virtual_robot',
    'setcmas_simu.ros': (
        'clocks cmd_vel_topics dds_setup fleet_node fleet_topic messages parameters polling '
        'process qos robot_state'
    ),
    'setcmas_tools.bags': 'player recorder',
    'setcmas_tools.page': 'live_topics',
}
"""The modules by their rooms."""

SEVERAL_MODULES = [
    'launch_scripts.commands.test_site_page',
    'launch_scripts.test_packages',
    'setcmas_ctrl.controllers.test_experiment',
    'setcmas_ctrl.controllers.test_failures',
    'setcmas_ctrl.laws.test_bad_scripts',
    'setcmas_ctrl.laws.test_ros1_scripts',
    'setcmas_expe.guard.test_service_manager',
    'setcmas_expe.test_bridge_starts',
    'setcmas_expe.test_faults',
    'setcmas_expe.test_foreign_controller',
    'setcmas_tools.grade.test_grader_messages',
    'setcmas_tools.grade.test_mistakes',
    'setcmas_tools.grade.test_right_solutions',
    'setcmas_tools.run.test_strange_files',
]
"""Tests of what several modules do together, which are not named after one."""


def modules():
    """Return the path of each module of the product by its dotted name."""
    found = {}
    for package in PACKAGES:
        for path in (ROOT / package / package).rglob('*.py'):
            parts = path.relative_to(ROOT / package).with_suffix('').parts
            found['.'.join(parts).removesuffix('.__init__')] = path
    return found


MODULES = modules()


DOCSTRING = re.compile(r'""".*?"""', re.DOTALL)
IMPORT = re.compile(r'^[ \t]*((?:from [\w.]+ )?import (?:\([^)]*\)|.*))', re.MULTILINE)


def imports(module, source):
    """Return the dotted names of what a module imports, anywhere in it."""
    names = set()
    for node in ast.parse('\n'.join(IMPORT.findall(DOCSTRING.sub('', source)))).body:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f'{module}: a relative import'
            whole = {f'{node.module}.{alias.name}' for alias in node.names}
            names |= {name if name in MODULES else node.module for name in whole}
    return names


@functools.cache
def all_imports():
    """Return the imports of each module: of their lines alone, as every worker needs them."""
    return {name: imports(name, path.read_text()) for name, path in MODULES.items()}


def room(module):
    """Return the room that a module is in: the folder below its package, or itself."""
    return '.'.join(module.split('.')[:2])


def circle(graph):
    """Return a circle in a graph, or None."""
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        return error.args[1]
    return None


@pytest.mark.parametrize('package', PACKAGES)
def test_dependencies_point_one_way(package):
    later = PACKAGES[PACKAGES.index(package) + 1 :]
    for module, names in all_imports().items():
        if module.split('.')[0] == package:
            assert not [name for name in names if name.split('.')[0] in later], module


def test_modules_import_each_other_in_no_circle():
    assert circle({name: names & MODULES.keys() for name, names in all_imports().items()}) is None


def test_rooms_import_each_other_in_no_circle():
    graph = {}
    for module, names in all_imports().items():
        ours = {room(name) for name in names if name in MODULES}
        graph.setdefault(room(module), set()).update(ours - {room(module)})
    assert circle(graph) is None


def test_a_package_has_rooms_and_a_room_has_no_rooms_inside():
    assert [name for name in MODULES if name.count('.') > 2] == []


def test_a_file_is_named_by_a_noun_that_exists_once():
    # A verb's file is named after it; a law has an exercise and a template of its name.
    named_after = ('commands', 'exercises', 'templates')
    rooms = {name.rpartition('.')[0] for name in MODULES}
    files = [name.split('.') for name in MODULES if name not in rooms]
    nouns = [parts[-1] for parts in files if not {*parts} & {*named_after}]
    assert [noun for noun, times in Counter(nouns).items() if times > 1] == []


def test_a_class_has_a_name_that_exists_once():
    classes = [
        node.name
        for name, path in MODULES.items()
        if not {*name.split('.')} & {'exercises', 'templates'}
        for node in ast.parse(path.read_text()).body
        if isinstance(node, ast.ClassDef)
    ]
    assert [name for name, times in Counter(classes).items() if times > 1] == []


def arrows():
    """Return the imports between each two folders, as pairs of modules."""
    found = {}
    for module, names in all_imports().items():
        for name in names & MODULES.keys():
            pair = module.rpartition('.')[0] or module, name.rpartition('.')[0] or name
            if len(set(pair)) == 2:
                found.setdefault(pair, []).append((module, name))
    return found


def test_the_house_is_small_enough_to_be_read():
    files = [name for name in MODULES if not name.startswith(ADDED_FREELY)]
    print(f'{len(files)} files, {len(arrows())} arrows')
    assert len(files) <= FILES
    assert len(arrows()) <= ARROWS


def test_few_folders_import_each_other_for_a_single_module():
    thin = [f'{one} imports {other}' for ((one, other), *more) in arrows().values() if not more]
    print(f'{len(thin)} arrows rest on a single import:', *sorted(thin), sep='\n')
    assert len(thin) <= THIN_ARROWS


def test_only_these_modules_import_ros():
    found = []
    for module, names in all_imports().items():
        tops = {name.split('.')[0] for name in names}
        if any(top in ROS or top.endswith('_msgs') for top in tops):
            found.append(module)
    allowed = [f'{room}.{one}' for room, names in MAY_IMPORT_ROS.items() for one in names.split()]
    assert sorted(found) == sorted(allowed)


def test_a_function_has_at_most_eight_parameters():
    for name, path in MODULES.items():
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef) and node.name != 'simulate':
                args = node.args
                names = [one.arg for one in args.posonlyargs + args.args + args.kwonlyargs]
                told = [one for one in names if one not in ('self', 'cls')]
                assert len(told) <= 8, f'{name}.{node.name}: {told}'


def test_a_room_holds_at_most_a_dozen_files_and_scripts():
    for package in PACKAGES:
        for folder in (ROOT / package / package).rglob('*'):
            is_free = folder.name in ('__pycache__', 'commands', 'algorithms', 'exercises')
            if folder.is_dir() and not is_free:
                inside = [path for path in folder.glob('*.py') if path.name != '__init__.py']
                assert len(inside) <= 14, f'{folder}: {len(inside)} files'


def test_tests_are_named_after_a_module_of_their_room():
    found = []
    for package in PACKAGES:
        for path in (ROOT / 'tests' / package).rglob('test_*.py'):
            name = '.'.join(path.relative_to(ROOT / 'tests').with_suffix('').parts)
            if name.replace('test_', '') not in MODULES:
                found.append(name)
    assert sorted(found) == SEVERAL_MODULES
