from xml.etree import ElementTree

from setcmas_tools.viewers.plotjuggler import plotjuggler_layout
from setcmas_tools.viewers.recording import RecordedTopics

TOPICS = {
    '/tb3_1/odom': 'nav_msgs/msg/Odometry',
    '/tb3_5/odom': 'nav_msgs/msg/Odometry',
    '/a "b" & <c>': 'std_msgs/msg/String',
}


def layout():
    text = plotjuggler_layout(RecordedTopics(TOPICS), '../bag/bag.mcap')
    return ElementTree.fromstring(text)


def test_every_plot_has_a_curve_for_each_robot_in_its_colour():
    plots = {area.get('name'): area.find('plot') for area in layout().iter('DockArea')}

    assert list(plots) == ['x (m)', 'y (m)', 'speed (m/s)', 'x (m), y (m)']
    speeds = [(curve.get('name'), curve.get('color')) for curve in plots['speed (m/s)']]
    assert speeds == [
        ('/tb3_1/odom/twist/twist/linear/x', '#ff0000'),
        ('/tb3_5/odom/twist/twist/linear/x', '#c7c7c7'),  # white cannot be seen on white
    ]


def test_the_plane_draws_y_over_x():
    (plane,) = (plot for plot in layout().iter('plot') if plot.get('mode') == 'XYPlot')

    first = plane[0].attrib
    assert first['name'] == 'tb3_1'
    assert first['curve_x'] == '/tb3_1/odom/pose/pose/position/x'
    assert first['curve_y'] == '/tb3_1/odom/pose/pose/position/y'


def test_splitters_count_their_plots():
    for splitter in layout().iter('DockSplitter'):
        assert int(splitter.get('count')) == len(splitter) == splitter.get('sizes').count(';') + 1


def test_it_opens_the_recording_without_a_question():
    info = layout().find('previouslyLoaded_Datafiles/fileInfo')

    assert info.get('filename') == '../bag/bag.mcap'
    chosen = info.find('plugin[@ID="DataLoad MCAP"]/parameters').get('selected_topics')
    assert chosen.split(';') == sorted(TOPICS)
