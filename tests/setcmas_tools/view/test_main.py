"""The page of the browser view, in a real browser."""

import contextlib
import io
import re
import shutil
import threading

import numpy as np
import pytest
from processes import CTRL, NO_WINDOWS, SETCMAS, SIMU
from terminals import Terminal

pytest.importorskip('rclpy')
from geometry_msgs.msg import Point
from ros_peer import position, velocity
from std_msgs.msg import Float32MultiArray, MultiArrayDimension, UInt16
from visualization_msgs.msg import Marker

from setcmas_simu.fleet import fleet
from setcmas_simu.ros import qos

needs_browser = pytest.mark.skipif(
    not (shutil.which('chromium') and shutil.which('chromedriver')),
    reason='chromium and chromium-driver are not installed',
)

ADDRESS = r'browser view:\s+(http\S+)\s'


def page_of(process):
    process.wait_for_output('browser view: http')
    return re.search(ADDRESS, process.output()).group(1)


def picture(browser):
    from PIL import Image

    return np.asarray(Image.open(io.BytesIO(browser.get_screenshot_as_png())).convert('RGB')) / 255


def share_of(colour, pixels):
    """Return the number of pixels in a colour's hue, or as dark or as pale as it is."""
    low, high = pixels.min(axis=-1), pixels.max(axis=-1)
    chroma = (pixels - low[..., None]) / np.maximum(high - low, 1e-6)[..., None]
    if np.ptp(colour) < 0.1:
        return int(((high - low < 0.06) & (abs(high - colour[0]) < 0.08)).sum())
    own = (np.array(colour) - min(colour)) / np.ptp(colour)
    saturated = high - low > 0.5 * np.ptp(colour)
    return int((saturated & (np.abs(chroma - own).max(axis=-1) < 0.22)).sum())


def robots_seen(browser):
    """Return the robots whose colours are in the picture left of the panel."""
    pixels = picture(browser)
    pixels = pixels[:, : int(0.62 * pixels.shape[1])]
    return [robot for robot in range(1, 9) if share_of(fleet.plot_colour(robot), pixels) >= 8]


@contextlib.contextmanager
def repeated(action):
    """Do something ten times a second: a picture may take longer than a flash lasts."""
    done = threading.Event()

    def repeat():
        while not done.wait(0.1):
            action()

    thread = threading.Thread(target=repeat)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


@needs_browser
@pytest.mark.nightly
def test_eight_robots_in_a_browser(start, peer):
    pytest.importorskip('viser')
    from browser import buttons, close_notifications, open_browser, wait_for, wait_for_text

    odometry = {robot: peer.odometry(robot) for robot in range(1, 9)}
    commands = {robot: peer.cmd_vel(robot) for robot in range(1, 9)}
    view = start(*SETCMAS, 'view', env=NO_WINDOWS)
    with open_browser(1000, 640) as browser:
        browser.get(page_of(view))
        wait_for_text(browser, 'Follow')  # the page is there before the fleet
        start(*SIMU, '--nb-robots', '8').wait_for_output('simulating')
        peer.wait_for(lambda: all(odometry.values()))
        homes = {robot: position(odometry[robot][-1]) for robot in odometry}
        wait_for_text(browser, '8 robots')
        wait_for_text(browser, 'standing')
        close_notifications(browser)
        buttons(browser)['Top'].click()
        wait_for(lambda: robots_seen(browser) == list(range(1, 9)))

        ctrl = start(*CTRL, '--algo', 'leader_follower_formation')
        ctrl.wait_for_output('controlling robots 1-8')
        wait_for_text(browser, 'run time')
        wait_for_text(browser, 'moving')
        peer.wait_for(lambda: all_move(commands))
        buttons(browser)['Pause'].click()
        peer.wait_for(lambda: all_stand(commands))
        wait_for_text(browser, 'paused')
        wait_for(lambda: 'Start' in buttons(browser))

        buttons(browser)['Reset'].click()
        peer.wait_for(lambda: all(position(odometry[r][-1]) == homes[r] for r in homes))
        buttons(browser)['Start'].click()
        peer.wait_for(lambda: all_move(commands))
        wait_for(lambda: 'Pause' in buttons(browser))

        buttons(browser)['Pause'].click()
        peer.wait_for(lambda: all_stand(commands))
        ctrl.end()
        ctrl = start(*CTRL, '--algo', 'leader_follower_formation')
        ctrl.wait_for_output('controlling robots 1-8')
        peer.wait_for_new(commands[1], 3)  # a controller that comes later is told of the pause
        peer.wait_for(lambda: all_stand(commands))
    assert view.end() == 0
    assert 'Traceback' not in view.output()
    assert len(view.output().splitlines()) == 1, view.output()


def all_move(commands):
    return all(kept and velocity(kept[-1]) != (0.0, 0.0) for kept in commands.values())


def all_stand(commands):
    return all(kept and velocity(kept[-1]) == (0.0, 0.0) for kept in commands.values())


@pytest.mark.nightly
@needs_browser
def test_a_run_that_ends_stays_on_the_page_until_the_terminal_says_go_on(tmp_path, monkeypatch):
    pytest.importorskip('viser')
    from browser import close_notifications, open_browser, text_of, wait_for_text
    from terminals import Terminal

    for name in ('CI', 'DISPLAY', 'WAYLAND_DISPLAY'):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.chdir(tmp_path)
    run = Terminal(
        'run', '--view', '--no-plots', '--algo', 'consensus', '--nb-robots', '3', '--duration',
        '15', '--output', 'out',
    )  # fmt: skip
    url = run.wait_for(ADDRESS).group(1)
    with open_browser(1000, 640) as browser:
        browser.get(url)
        wait_for_text(browser, '3 robots')
        assert browser.title == 'setcmas'
        close_notifications(browser)
        run.wait_for('until you press Enter')
        wait_for_text(browser, 'run ended')
        assert [robot for robot in robots_seen(browser) if robot <= 3] == [1, 2, 3]
        assert 'lost' not in text_of(browser)
        assert run.process.poll() is None
        run.press('\n')
        assert run.wait() == 0


def press(browser, label, peer, condition):
    """Press until a condition holds: a page that is still being built moves under the mouse."""
    from browser import buttons, wait_for

    def holds():
        if pause := buttons(browser).get(label):
            pause.click()
        peer.spin(2.0)
        return condition()

    wait_for(holds)


@pytest.mark.nightly
@needs_browser
def test_several_pages_know_of_each_other_and_some_only_look(start, peer):
    pytest.importorskip('viser')
    from browser import buttons, open_browser, open_window, wait_for, wait_for_text

    start(*SIMU, '--nb-robots', '2')
    commands = {robot: peer.cmd_vel(robot) for robot in (1, 2)}
    start(*CTRL, '--algo', 'traj_tracking').wait_for_output('controlling robots 1-2')
    view = start(*SETCMAS, 'view', env=NO_WINDOWS)
    with open_browser(1000, 640) as browser:
        browser.get(page_of(view))
        wait_for_text(browser, 'moving')
        first = browser.current_window_handle
        open_window(browser)
        browser.get(page_of(view))
        wait_for_text(browser, '2 robots')
        press(browser, 'Pause', peer, lambda: all_stand(commands))
        browser.close()
        browser.switch_to.window(first)
        wait_for_text(browser, 'paused')
        wait_for(lambda: 'Start' in buttons(browser))

        watch = start(*SETCMAS, 'view', '--read-only', '--host', '0.0.0.0', env=NO_WINDOWS)
        open_window(browser)
        browser.get(page_of(watch))
        wait_for_text(browser, '2 robots')
        assert 'Screenshot' in buttons(browser)
        assert not {'Pause', 'Start', 'Reset'} & set(buttons(browser))
    assert 'token' not in watch.output()


@needs_browser
def test_what_is_drawn_communicated_and_lost(start, peer):
    pytest.importorskip('viser')
    from browser import buttons, close_notifications, open_browser, wait_for, wait_for_text

    simu = start(*SIMU, '--nb-robots', '2', '--pose', '1:-3,0', '--pose', '2:3,0')
    view = start(*SETCMAS, 'view', '--host', '0.0.0.0', env=NO_WINDOWS)
    markers = peer.node.create_publisher(Marker, '/tb3_1/goal', qos.LATCHED)
    graph = peer.node.create_publisher(Float32MultiArray, '/communication_graph', qos.LATCHED)
    events = peer.node.create_publisher(UInt16, '/tb3_1/trig_event', 10)
    cyan, orange = (0.0, 0.8, 0.8), (0.9, 0.5, 0.0)
    goal = Marker(type=Marker.CUBE)
    goal.header.frame_id = 'world'
    goal.scale.x = goal.scale.y = goal.scale.z = 1.5
    goal.pose.position.y = 3.0
    goal.color.g, goal.color.b, goal.color.a = 0.8, 0.8, 1.0
    markers.publish(goal)
    line = Marker(type=Marker.LINE_STRIP, id=1, points=[Point(y=-3.0), Point(x=3.0, y=-3.0)])
    line.header.frame_id = 'world'
    line.scale.x = 0.4
    line.color.r, line.color.g, line.color.a = (*orange[:2], 1.0)
    other = peer.node.create_publisher(Marker, '/tb3_2/way', qos.LATCHED)
    other.publish(line)
    sizes = [MultiArrayDimension(label=label, size=2) for label in ('receiver', 'sender')]
    message = Float32MultiArray(data=[0.0, 1.0, 1.0, 0.0])
    message.layout.dim = sizes
    graph.publish(message)

    with open_browser(1000, 640) as browser:
        browser.get(page_of(view))
        wait_for_text(browser, '2 robots')
        close_notifications(browser)
        buttons(browser)['Top'].click()

        def left_of_the_panel():
            return picture(browser)[:, :620]

        def link_is_red():
            """Whether the link glows in the colour of its sender halfway to robot 2."""
            pixels = left_of_the_panel()
            middle = pixels[:, pixels.shape[1] // 2 - 40 : pixels.shape[1] // 2 + 40]
            return share_of((1.0, 0.0, 0.0), middle) > 3

        wait_for(lambda: share_of(cyan, left_of_the_panel()) > 100)
        wait_for(lambda: share_of(orange, left_of_the_panel()) > 100)
        with repeated(lambda: events.publish(UInt16(data=1))):
            wait_for(link_is_red)
        goal.action = Marker.DELETE
        markers.publish(goal)
        wait_for(lambda: share_of(cyan, left_of_the_panel()) == 0)
        peer.node.destroy_publisher(other)
        wait_for(lambda: share_of(orange, left_of_the_panel()) == 0)
        peer.node.destroy_publisher(graph)
        with repeated(lambda: events.publish(UInt16(data=1))):
            wait_for(lambda: not link_is_red())

        start(*SIMU, '--nb-robots', '3', '--robots', '3')
        wait_for_text(browser, '3 robots')
        simu.end()
        wait_for_text(browser, 'lost')
        assert view.popen.poll() is None
    assert 'whoever has this address can press the buttons' in view.output()


@pytest.mark.nightly
@needs_browser
def test_only_the_page_that_the_experiment_has_opened_starts_robots(domain):
    pytest.importorskip('viser')
    from browser import buttons, close_notifications, open_browser, wait_for_text

    terminal = Terminal('expe', '--emulate', '--algo', 'nav_wp', '--no-joystick', '--view')
    other = Terminal('view')
    try:
        addresses = {page: page.wait_for(ADDRESS).group(1) for page in (other, terminal)}
        with open_browser(1000, 640) as browser:
            for opened, may_start in ((other, False), (terminal, True)):
                browser.get(addresses[opened])
                wait_for_text(browser, '1 robot')
                close_notifications(browser)
                wait_for_text(browser, 'Start' if may_start else 'Start: in the terminal only')
            click = buttons(browser)['Start'].click
            terminal.start_robots('started: on the page', click)
            buttons(browser)['EMERGENCY STOP'].click()
            terminal.wait_for('EMERGENCY STOP by /emergency_stop')
            wait_for_text(browser, 'press R twice')
    finally:
        other.close()
        terminal.close()


def test_a_taken_port_and_an_end_without_any_robots(start):
    pytest.importorskip('viser')
    first = start(*SETCMAS, 'view', '--port', '18980', env=NO_WINDOWS)
    port = page_of(first).rpartition(':')[2]
    second = start(*SETCMAS, 'view', '--port', port, env=NO_WINDOWS)

    assert page_of(second) != page_of(first)
    assert f'(port {port} is taken)' in second.output()
    for process in (first, second):
        assert process.end() == 0
        assert 'Traceback' not in process.output()
