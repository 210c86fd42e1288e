"""Plugins of another package, without installing it."""

from types import SimpleNamespace

from setcmas_simu import plugins
from setcmas_simu.plugins import Plugin


def add_plugins(monkeypatch, group, **things):
    """Add objects of the package my-lab 1.0 to a group, by name."""
    installed = plugins._plugins
    own = {
        name: Plugin(name, 'my-lab', '1.0', SimpleNamespace(load=lambda thing=thing: thing))
        for name, thing in things.items()
    }
    monkeypatch.setattr(
        plugins,
        '_plugins',
        lambda name: installed(name) | (own if name == group.name else {}),
    )
