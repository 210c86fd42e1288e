import pytest

from setcmas_tools.page.browser import has_display, may_open_windows


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
