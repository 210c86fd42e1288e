import sys

from launch_scripts.processes.node_commands import node_command


def test_nodes_run_with_this_interpreter():
    command = node_command('some.module', ['--option', 'value'])

    assert command[0] == sys.executable
    assert command[-3:] == ['some.module', '--option', 'value']
