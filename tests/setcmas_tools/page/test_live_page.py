"""The live page, in a real browser."""

import re

import pytest
from processes import CTRL, NO_WINDOWS, PATIENT_LAB, SETCMAS, SIMU
from terminals import Terminal

pytest.importorskip('rclpy')
from geometry_msgs.msg import Point
from ros_peer import position, velocity
from std_msgs.msg import Float32MultiArray, MultiArrayDimension, UInt16
from visualization_msgs.msg import Marker

from setcmas_simu.ros import qos

ADDRESS = r'browser view:\s+(http\S+)\s'
SHAPES = (
    "return page.shapes.filter(one => one.to === Infinity).map(one => one.kind).sort().join(' ')"
)


def page_of(process):
    process.wait_for_output('browser view: http')
    return re.search(ADDRESS, process.output()).group(1)


def text(browser, name):
    return browser.find_element('id', name).text


def click(browser, name):
    browser.find_element('id', name).click()


def rows(browser):
    """Return the cells of the table by robot."""
    js = "return [...document.querySelectorAll('#robots tr')].map(row => row.innerText)"
    return {cells[0]: cells[1:] for cells in map(str.split, browser.execute_script(js))}


def wait_until_it_goes_on(browser):
    from browser import wait_for

    end = 'return page.times.length'
    count = browser.execute_script(end)
    wait_for(lambda: browser.execute_script(end) > count + 5)


def all_move(commands):
    return all(kept and velocity(kept[-1]) != (0.0, 0.0) for kept in commands.values())


def all_stand(commands):
    return all(kept and velocity(kept[-1]) == (0.0, 0.0) for kept in commands.values())


@pytest.mark.usefixtures('needs_chromium')
@pytest.mark.nightly
def test_a_simulation_is_paused_reset_started_and_scrubbed(start, peer):
    from browser import open_browser, open_window, wait_for

    odometry = {robot: peer.odometry(robot) for robot in (1, 2, 3)}
    commands = {robot: peer.cmd_vel(robot) for robot in odometry}
    view = start(*SETCMAS, 'view', env=NO_WINDOWS)
    with open_browser(1280, 800) as browser:
        browser.get(page_of(view))
        wait_for(lambda: text(browser, 'state') == 'waiting for robots')  # before the fleet
        start(*SIMU, '--nb-robots', '3').wait_for_output('simulating')
        peer.wait_for(lambda: all(odometry.values()))
        homes = {robot: position(odometry[robot][-1]) for robot in odometry}
        wait_for(lambda: [row[-1] for row in rows(browser).values()] == ['standing'] * 3)
        start(*CTRL, '--algo', 'leader_follower_formation')
        wait_for(lambda: text(browser, 'title') == '3 robots')
        wait_for(lambda: text(browser, 'state') == 'running')
        peer.wait_for(lambda: all_move(commands))

        click(browser, 'back')
        wait_for(lambda: text(browser, 'now').endswith('s ago'))
        wait_until_it_goes_on(browser)  # after messages that were on their way
        place = rows(browser)
        wait_until_it_goes_on(browser)
        assert rows(browser) == place
        click(browser, 'latest')
        wait_for(lambda: rows(browser) != place and 'ago' not in text(browser, 'now'))

        open_window(browser)
        browser.get(page_of(view))
        wait_for(lambda: text(browser, 'pause') == 'Pause')
        click(browser, 'pause')
        peer.wait_for(lambda: all_stand(commands))
        browser.close()
        browser.switch_to.window(browser.window_handles[0])
        wait_for(lambda: text(browser, 'state') == 'paused' and text(browser, 'pause') == 'Start')
        click(browser, 'reset')
        peer.wait_for(lambda: all(position(odometry[r][-1]) == homes[r] for r in homes))
        click(browser, 'pause')
        peer.wait_for(lambda: all_move(commands))
        assert browser.get_log('browser') == []
    assert view.end() == 0
    assert len(view.output().splitlines()) == 1, view.output()


@pytest.mark.nightly
@pytest.mark.usefixtures('needs_chromium')
def test_markers_links_broadcasts_and_lost_robots(start, peer):
    from browser import open_browser, wait_for

    simu = start(*SIMU, '--nb-robots', '2', '--pose', '1:-3,0', '--pose', '2:3,0')
    view = start(*SETCMAS, 'view', '--host', '0.0.0.0', '--read-only', env=NO_WINDOWS)
    markers = peer.node.create_publisher(Marker, '/tb3_1/goal', qos.LATCHED)
    graph = peer.node.create_publisher(Float32MultiArray, '/communication_graph', qos.LATCHED)
    events = peer.node.create_publisher(UInt16, '/tb3_1/trig_event', 10)
    goal = Marker(type=Marker.SPHERE)
    goal.scale.x = goal.scale.y = goal.pose.position.y = goal.color.a = 1.0
    markers.publish(goal)
    line = Marker(type=Marker.LINE_STRIP, id=1, points=[Point(y=-3.0), Point(x=3.0, y=-3.0)])
    other = peer.node.create_publisher(Marker, '/tb3_2/way', qos.LATCHED)
    other.publish(line)
    message = Float32MultiArray(data=[0.0, 1.0, 1.0, 0.0])
    message.layout.dim = [MultiArrayDimension(size=2), MultiArrayDimension(size=2)]
    graph.publish(message)

    with open_browser(390, 844) as browser:
        browser.get(page_of(view))

        def expect(js, value):
            wait_for(lambda: browser.execute_script(js) == value)

        expect('return page.robots.length', 2)
        expect(SHAPES, 'discs lines')
        expect('return page.linksAt(Infinity).size', 2)

        def broadcast():
            events.publish(UInt16(data=1))
            return browser.execute_script('return page.robots[0].sent.length') > 0

        wait_for(broadcast)
        peer.node.destroy_publisher(markers)
        expect(SHAPES, 'lines')
        peer.node.destroy_publisher(other)
        expect(SHAPES, '')
        peer.node.destroy_publisher(graph)
        expect('return page.linksAt(Infinity).size', 0)
        start(*SIMU, '--nb-robots', '3', '--robots', '3')
        wait_for(lambda: 'tb3_3' in rows(browser))
        simu.end()
        wait_for(lambda: text(browser, 'detail') == '2 lost')
        assert not browser.find_element('id', 'pause').is_displayed()
    assert 'token' not in view.output()


@pytest.mark.nightly
@pytest.mark.usefixtures('needs_chromium')
def test_a_page_stops_an_experiment_and_never_starts_it(domain):
    from browser import open_browser, wait_for

    terminal = Terminal('expe', *PATIENT_LAB, '--algo', 'nav_wp', '--no-joystick', '--view')
    try:
        address = terminal.wait_for(ADDRESS).group(1)
        with open_browser(1000, 640) as browser:
            browser.get(address)
            wait_for(lambda: text(browser, 'state') == 'paused')
            wait_for(lambda: browser.find_element('id', 'stop').is_displayed())
            assert not browser.find_element('id', 'pause').is_enabled()
            assert not browser.find_element('id', 'reset').is_displayed()
            terminal.start_robots(lambda: text(browser, 'state') == 'running')
            click(browser, 'stop')
            # The guard may hear it first, and the pause node then learns it from the guard.
            terminal.wait_for('STOP (by /emergency_stop|held by the guard)')
            wait_for(lambda: text(browser, 'state') == 'STOP HELD')
            ask = "document.getElementById('pause').disabled = false"
            browser.execute_script(ask)
            click(browser, 'pause')
            wait_for(lambda: 'STOPPED' in text(browser, 'stop'))
    finally:
        terminal.close()


def test_a_taken_port_and_an_end_without_any_robots(start):
    first = start(*SETCMAS, 'view', '--port', '18980', env=NO_WINDOWS)
    port = page_of(first).rpartition(':')[2]
    second = start(*SETCMAS, 'view', '--port', port, env=NO_WINDOWS)

    assert page_of(second) != page_of(first)
    assert f'(port {port} is taken)' in second.output()
    for process in (first, second):
        assert process.end() == 0
        assert 'Traceback' not in process.output()
