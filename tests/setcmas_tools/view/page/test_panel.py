from setcmas_tools.view.model.robot_states import ERROR, OK, WARN
from setcmas_tools.view.page.panel import RobotRow, panel_html

ROWS = [
    RobotRow(1, 0.5, (1.234, -2.0, 1.5707963), OK, 'moving'),
    RobotRow(2, -0.001, (0.0, 0.0, 0.0), WARN, 'stopped: <too near>'),
]


def test_a_row_per_robot_with_its_colour():
    text = panel_html(ROWS, 'running', 12.34, 0.5678)

    assert '2 robots' in text
    assert '12.3 s' in text
    assert '0.568 m' in text
    assert '−0.00' not in text
    for part in ('rgb(255,0,0)', '1.23', '−2.00', '>90<', 'moving'):
        assert part in text


def test_robots_that_are_lost_are_counted_apart():
    gone = [RobotRow(robot, 0.0, (0.0, 0.0, 0.0), ERROR, 'lost', lost=True) for robot in (3, 4)]

    assert '>2 robots, 2 lost<' in panel_html([*ROWS, *gone], 'running', 1.0, None)
    assert '>0 robots, 2 lost<' in panel_html(gone, 'running', 1.0, None)


def test_texts_of_others_are_no_html():
    assert '&lt;too near&gt;' in panel_html(ROWS, 'paused', None, None)


def test_before_the_robots_and_before_the_run():
    assert 'waiting for robots' in panel_html([], 'paused', None, None)
    one = panel_html(ROWS[:1], 'not controlled yet', None, None)
    assert '1 robot<' in one
    assert 'not controlled yet' in one
    assert 'run time' not in one
