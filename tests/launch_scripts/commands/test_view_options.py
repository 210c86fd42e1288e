import re
from pathlib import Path

import pytest
from processes import NO_WINDOWS, SETCMAS, TIMEOUT_S, run_setcmas

from launch_scripts.commands.view_options import (
    AUTO,
    BROWSER,
    NONE,
    Choice,
    ViewOptions,
    choose_view,
)
from setcmas_simu.errors import SetcmasError
from setcmas_tools.view.page.browser_options import INSTALL_VISER

NO_RVIZ = 'rviz2 is not installed'


@pytest.mark.parametrize(
    ('view', 'rviz', 'attended', 'no_rviz', 'viser', 'choice'),
    [
        (AUTO, False, True, '', True, Choice(rviz=True)),
        (AUTO, False, True, NO_RVIZ, True, Choice(browser=True)),
        (AUTO, False, False, '', True, Choice()),
        (AUTO, True, True, '', True, Choice(rviz=True)),
        (AUTO, True, False, NO_RVIZ, True, Choice(rviz=True)),  # its absence is told elsewhere
        (BROWSER, False, False, '', True, Choice(browser=True)),
        (BROWSER, True, True, '', True, Choice(rviz=True, browser=True)),
        (NONE, False, True, '', True, Choice()),
        (NONE, True, True, '', True, Choice(rviz=True)),
    ],
)
def test_what_is_started(view, rviz, attended, no_rviz, viser, choice):
    assert choose_view(ViewOptions(view=view, rviz=rviz), attended, no_rviz, viser) == choice


def test_where_nothing_can_be_shown_that_is_said():
    choice = choose_view(ViewOptions(), True, NO_RVIZ, False)

    assert not choice.rviz
    assert not choice.browser
    assert INSTALL_VISER in choice.remark


def test_the_viser_that_is_asked_for_is_that_of_the_extra():
    project = (Path(__file__).parents[3] / 'pyproject.toml').read_text(encoding='utf-8')
    asked = INSTALL_VISER.split("'")[1]

    assert f'view = ["{asked}"' in project


def test_a_page_that_is_wanted_needs_viser():
    with pytest.raises(SetcmasError, match=re.escape(INSTALL_VISER)):
        choose_view(ViewOptions(view=BROWSER), True, '', False)


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (('view', '--port', '0'), '--port is 0; it must be a whole number from 1 to 65535'),
        (('view', '--host', 'nowhere.invalid'), "host 'nowhere.invalid' is not an address"),
        (('view', '--host', '192.0.2.7'), "host '192.0.2.7' is not an address"),
        (('simu', '--view', 'gazebo'), "--view is 'gazebo'; it must be auto, browser or none"),
    ],
)
def test_mistakes_are_told_on_one_line(domain, arguments, message):
    pytest.importorskip('rclpy')
    pytest.importorskip('viser')

    result = run_setcmas(*arguments)

    assert result.returncode == 2
    assert message in result.stderr
    assert result.stderr.count('\n') == 1


def test_the_page_beside_a_simulation_ends_with_it_and_not_the_other_way_round(start):
    psutil = pytest.importorskip('psutil')
    pytest.importorskip('rclpy')
    pytest.importorskip('viser')
    process = start(*SETCMAS, 'simu', '--view', env=NO_WINDOWS)
    process.wait_for_output('browser view: http://127.0.0.1:')
    process.wait_for_output('simulating robot 1')
    nodes = psutil.Process(process.pid).children()
    page = next(
        node for node in nodes if any('setcmas_tools.view.main' in word for word in node.cmdline())
    )

    page.terminate()
    process.wait_for_output('view has ended; all else goes on')
    assert process.end() == 0
    psutil.wait_procs(nodes, timeout=TIMEOUT_S)
    assert not any(node.is_running() for node in nodes)
    assert 'Traceback' not in process.output()
