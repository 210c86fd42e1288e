import subprocess
import sys

import pytest

from setcmas_tools.view.page.desktop import has_display, may_open_windows

PURE = (
    'page.browser_options model.camera_places model.communication page.desktop model.fleet_view '
    'model.marker_shapes model.marker_store scene.meshes page.panel scene.robot_mesh '
    'model.robot_states model.run_clock scene.tone model.trails'
)


@pytest.mark.parametrize(
    ('environment', 'platform', 'display', 'desktop'),
    [
        ({}, 'linux', False, False),
        ({'DISPLAY': ':0'}, 'linux', True, True),
        ({'WAYLAND_DISPLAY': 'wayland-0'}, 'linux', True, True),
        ({'DISPLAY': 'localhost:10', 'SSH_CONNECTION': '1'}, 'linux', True, False),
        ({'DISPLAY': ':99', 'CI': 'true'}, 'linux', True, False),
        ({}, 'darwin', True, True),
    ],
)
def test_windows_are_opened_where_the_user_sits(environment, platform, display, desktop):
    assert has_display(environment, platform) == display
    assert may_open_windows(environment, platform) == desktop


def test_the_pure_modules_need_neither_viser_nor_ros():
    program = (
        'import sys, importlib\n'
        "sys.modules['viser'] = sys.modules['rclpy'] = None\n"
        'for name in sys.argv[1:]:\n'
        "    importlib.import_module(f'setcmas_tools.view.{name}')\n"
    )
    subprocess.run([sys.executable, '-c', program, *PURE.split()], check=True)
