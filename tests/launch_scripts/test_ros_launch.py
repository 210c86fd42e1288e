"""The experiment's launch file, up to where the package `launch` takes over, without a wheel."""

import ast
from pathlib import Path

import pytest

from launch_scripts.cli import build_parser
from launch_scripts.ros_launch import command_line, launch_arguments

FILE = Path(__file__).parents[2] / 'launch_scripts' / 'launch' / 'expe_multi_robots.launch.py'


def test_what_the_launch_file_starts_is_a_command_with_its_defaults():
    (call,) = (
        node
        for node in ast.walk(ast.parse(FILE.read_text()))
        if isinstance(node, ast.Call) and getattr(node.func, 'id', '') == 'description'
    )
    verb = ast.literal_eval(call.args[0])
    defaults = {one.arg: ast.literal_eval(one.value) for one in call.keywords}

    args = build_parser(verb).parse_args(command_line(verb, defaults)[1:])
    for name, text in defaults.items():
        assert str(getattr(args, name)) == text


@pytest.mark.parametrize(
    ('verb', 'values', 'words'),
    [
        ('simu', {'pose': '1:0,0 2:1,-1'}, ['--pose=1:0,0', '--pose=2:1,-1']),
        ('ctrl', {'algo': 'my law.py', 'watch': 'true'}, ['--algo=my law.py', '--watch']),
        ('ctrl', {'algo': 'consensus', 'watch': 'false', 'exercise': ''}, ['--algo=consensus']),
        ('simu', {'ros_args': '-p rate:=9'}, ['--ros-args', '-p', 'rate:=9']),
        ('record', {'topics': '/a /b', 'output': 'bag'}, ['--output=bag', '--topics', '/a', '/b']),
    ],
)
def test_arguments_are_typed_as_options(verb, values, words):
    command = command_line(verb, values)

    assert sorted(command) == sorted(['setcmas', verb, *words])
    build_parser(verb).parse_args(command[1:])


def test_every_option_of_a_verb_is_an_argument_with_a_help_text():
    arguments = {one.dest: one for one in launch_arguments('simu')}

    assert {'nb_robots', 'model', 'rviz', 'rtf'} <= arguments.keys()
    assert all(one.help for one in arguments.values())
