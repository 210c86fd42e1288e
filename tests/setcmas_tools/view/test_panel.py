from setcmas_tools.view.panel import RobotRow, panel_html
from setcmas_tools.view.robot_states import OK, WARN

ROWS = [
    RobotRow(1, 0.5, (1.234, -2.0, 1.5707963), OK, 'moving'),
    RobotRow(2, -0.001, (0.0, 0.0, 0.0), WARN, 'stopped: <too near>'),
]


def test_a_row_per_robot_with_its_colour():
    text = panel_html(ROWS, 12.34, 0.5678, False)

    assert '2 robots' in text
    assert '12.3 s' in text
    assert '0.568 m' in text
    assert '−0.00' not in text
    for part in ('rgb(255,0,0)', '1.23', '−2.00', '>90<', 'moving'):
        assert part in text


def test_texts_of_others_are_no_html():
    assert '&lt;too near&gt;' in panel_html(ROWS, None, None, True)


def test_before_the_robots_and_before_the_run():
    assert 'waiting for robots' in panel_html([], None, None, False)
    one = panel_html(ROWS[:1], None, None, False)
    assert '1 robot<' in one
    assert 'run time' not in one
