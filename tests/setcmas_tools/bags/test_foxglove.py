import json
import re

import pytest
from rosbags.typesys import Stores, get_typestore

from setcmas_simu.fleet.palettes import plot_hex
from setcmas_tools.bags.foxglove import foxglove_layout, odometry_topics, write_layout

MARKER, ARRAY = (f'visualization_msgs/msg/{name}' for name in ('Marker', 'MarkerArray'))
ODOMETRY = 'nav_msgs/msg/Odometry'

SIMULATED = {
    '/tb3_10/odom': ODOMETRY,
    '/tb3_2/odom': ODOMETRY,
    '/tb3_2/marker': MARKER,
    '/tb3_2/traj_ref': ARRAY,
    '/tb3_2/trig_event': 'std_msgs/msg/UInt16',
    '/tf': 'tf2_msgs/msg/TFMessage',
}
REAL = {
    '/arena': ARRAY,
    '/diagnostics': 'diagnostic_msgs/msg/DiagnosticArray',
    '/emergency_stopped': 'std_msgs/msg/Bool',
    '/mocap/tb3_1/odom': ODOMETRY,
    '/paused': 'std_msgs/msg/Bool',
    '/tb3_1/odom': ODOMETRY,
}


def panels(layout):
    """Return the panels of a tree of splits from left to right."""
    if isinstance(layout, str):
        return [layout]
    return panels(layout['first']) + panels(layout['second'])


def snake(content):
    if isinstance(content, list):
        return [snake(one) for one in content]
    if isinstance(content, dict):
        return {
            re.sub('[A-Z]', lambda c: f'_{c[0].lower()}', k): snake(v) for k, v in content.items()
        }
    return content


def read_by(kind, series, panel):
    """Return the content of a panel that a class of Foxglove's library has read and written."""
    read = snake({key: value for key, value in panel.items() if key != 'foxglovePanelTitle'})
    if series:
        read['paths'] = [series(**path) for path in read['paths']]
    return json.loads(kind(**read).to_json())


@pytest.mark.parametrize('topics', [SIMULATED, REAL])
def test_all_panels_are_in_the_tree(topics):
    layout = foxglove_layout(topics)

    assert sorted(panels(layout['layout'])) == sorted(layout['configById'])


def test_robots_are_curves_of_their_colours_in_order():
    plot = foxglove_layout(SIMULATED)['configById']['Plot!1']

    assert plot['foxglovePanelTitle'] == 'y (m)'
    assert [path['value'] for path in plot['paths']] == [
        '/tb3_2/odom.pose.pose.position.y',
        '/tb3_10/odom.pose.pose.position.y',
    ]
    assert plot['paths'][0]['color'] == plot_hex(2)


def test_scene_shows_all_markers_of_the_recording():
    scene = foxglove_layout(SIMULATED)['configById']['3D!scene']

    assert scene['topics'] == {
        '/tb3_2/marker': {'visible': True},
        '/tb3_2/traj_ref': {'visible': True},
    }
    assert scene['followTf'] == 'world'


def test_experiments_show_motion_capture_pauses_and_diagnostics():
    shown = foxglove_layout(REAL)['configById']

    assert shown['Plot!0']['paths'][0]['value'] == '/mocap/tb3_1/odom.pose.pose.position.x'
    states = shown['StateTransitions!states']['paths']
    assert [path['value'] for path in states] == ['/paused.data', '/emergency_stopped.data']
    assert shown['DiagnosticSummary!diagnostics']['topicToRender'] == '/diagnostics'


@pytest.mark.parametrize('topics', [SIMULATED, REAL])
def test_every_field_is_one_of_its_message_type(topics):
    store = get_typestore(Stores.ROS2_JAZZY)
    shown = foxglove_layout(topics)['configById']
    paths = [path['value'] for panel in shown.values() for path in panel.get('paths', ())]

    assert paths
    for path in paths:
        topic, *fields = path.split('.')
        kind = topics[topic]
        for field in fields:
            _, inner = dict(store.get_msgdef(kind).fields)[field]
            kind = inner[0] if isinstance(inner, tuple) else inner
        assert kind in ('bool', 'float64', 'uint16')


@pytest.mark.parametrize('topics', [SIMULATED, REAL])
def test_the_library_of_foxglove_reads_every_panel(topics):
    library = pytest.importorskip('foxglove.layouts')
    kinds = {
        'Plot': (library.PlotConfig, library.PlotSeries),
        'StateTransitions': (library.StateTransitionsConfig, library.StateTransitionsSeries),
        'DiagnosticSummary': (library.DiagnosticsSummaryConfig, None),
    }
    shown = foxglove_layout(topics)['configById']
    for name, panel in shown.items():
        if kind := kinds.get(name.partition('!')[0]):
            title = {key: panel[key] for key in panel if key == 'foxglovePanelTitle'}
            assert read_by(*kind, panel) | title == panel


def test_the_library_of_foxglove_knows_all_of_the_scene():
    library = pytest.importorskip('foxglove.layouts')
    scene = foxglove_layout(REAL)['configById']['3D!scene']
    layer = {k: v for k, v in scene['layers']['metres'].items() if k != 'layerId'}
    read = library.ThreeDeeConfig(
        follow_tf=scene['followTf'],
        follow_mode=scene['followMode'],
        camera_state=library.ThreeDeeCameraState(**snake(scene['cameraState'])),
        scene=library.BaseRendererSceneSettings(
            transforms=library.BaseRendererTransforms(**snake(scene['scene']['transforms']))
        ),
        topics={
            name: library.BaseRendererRosMarkerTopicSettings(**snake(settings))
            for name, settings in scene['topics'].items()
        },
        transforms={},
        layers={'metres': library.BaseRendererGridLayerSettings(**snake(layer))},
    )

    assert json.loads(read.to_json()) | {'foxglovePanelTitle': 'fleet'} == scene


@pytest.mark.parametrize(
    ('bag', 'file'),
    [('out/bag', 'out/layouts/foxglove.json'), ('rec', 'rec_layouts/foxglove.json')],
)
def test_the_layout_is_written_next_to_the_bag(tmp_path, bag, file):
    (tmp_path / bag).mkdir(parents=True)

    assert write_layout(tmp_path / bag, {'/tb3_1/odom': ODOMETRY}) == tmp_path / file
    assert 'configById' in json.loads((tmp_path / file).read_text())


def test_without_robots_no_layout_is_written(tmp_path):
    assert write_layout(tmp_path / 'bag', {'/number': 'std_msgs/msg/UInt16'}) is None
    assert list(tmp_path.iterdir()) == []


def test_poses_of_motion_capture_go_before_those_of_wheels():
    names = ('/tb3_1/odom', '/mocap/tb3_1/odom', '/emulated_lab/truth/tb3_1', '/tb3_12/odom')
    found = odometry_topics(dict.fromkeys(names, ODOMETRY))

    assert found == {1: '/mocap/tb3_1/odom', 12: '/tb3_12/odom'}
