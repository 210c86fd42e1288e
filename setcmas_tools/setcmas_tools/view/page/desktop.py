"""Desktop of the user: whether windows can be shown on it."""

from __future__ import annotations

from collections.abc import Mapping


def has_display(environment: Mapping[str, str], platform: str) -> bool:
    """Return whether windows can be opened at all.

    Args:
        environment: Variables, as in os.environ.
        platform: As sys.platform.
    """
    if platform in ('win32', 'darwin'):
        return True
    return bool(environment.get('DISPLAY') or environment.get('WAYLAND_DISPLAY'))


def may_open_windows(environment: Mapping[str, str], platform: str) -> bool:
    """Return whether the user sits in front of the display: not over ssh, not in CI."""
    elsewhere = ('SSH_CONNECTION', 'SSH_TTY', 'CI')
    return has_display(environment, platform) and not any(map(environment.get, elsewhere))
