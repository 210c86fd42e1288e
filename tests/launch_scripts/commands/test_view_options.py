import pytest
from processes import NO_WINDOWS, SETCMAS, TIMEOUT_S, run_here, run_setcmas

from launch_scripts.commands.view_options import (
    AUTO,
    BROWSER,
    NONE,
    ViewOptions,
    choose_view,
)

NO_RVIZ = 'rviz2 is not installed'


@pytest.mark.parametrize(
    ('view', 'rviz', 'attended', 'no_rviz', 'choice'),
    [
        (AUTO, False, True, '', (True, False)),
        (AUTO, False, True, NO_RVIZ, (False, True)),
        (AUTO, False, False, '', (False, False)),
        (AUTO, True, True, '', (True, False)),
        (AUTO, True, False, NO_RVIZ, (True, False)),  # its absence is reported elsewhere
        (BROWSER, False, False, '', (False, True)),
        (BROWSER, True, True, '', (True, True)),
        (NONE, False, True, '', (False, False)),
        (NONE, True, True, '', (True, False)),
    ],
)
def test_what_is_started(view, rviz, attended, no_rviz, choice):
    assert choose_view(ViewOptions(view=view, rviz=rviz), attended, no_rviz) == choice


@pytest.mark.parametrize(
    ('run', 'arguments', 'message'),
    [
        (run_setcmas, ('view', '--host', '192.0.2.7'), "host '192.0.2.7' is not an address"),
        (run_here, ('simu', '--view', 'gazebo'), "--view is 'gazebo'; it must be auto, browser"),
    ],
)
def test_mistakes_are_reported_on_one_line(domain, run, arguments, message):
    pytest.importorskip('rclpy')

    result = run(*arguments)

    assert result.returncode == 2
    assert message in result.stderr
    assert result.stderr.count('\n') == 1


def test_the_page_of_a_simulation_ends_with_it_and_not_the_other_way_round(start):
    psutil = pytest.importorskip('psutil')
    pytest.importorskip('rclpy')
    process = start(*SETCMAS, 'simu', '--view', env=NO_WINDOWS)
    process.wait_for_output('browser view: http://127.0.0.1:')
    process.wait_for_output('simulating robot 1')
    nodes = psutil.Process(process.pid).children()
    page = next(
        node
        for node in nodes
        if any('setcmas_tools.page.viewer' in word for word in node.cmdline())
    )

    page.terminate()
    process.wait_for_output('view has ended; everything else continues')
    assert process.end() == 0
    psutil.wait_procs(nodes, timeout=TIMEOUT_S)
    assert not any(node.is_running() for node in nodes)
    assert 'Traceback' not in process.output()
