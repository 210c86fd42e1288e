"""Plugins of another package, without installing it."""

from dataclasses import dataclass, field

from setcmas_simu import plugins
from setcmas_simu.plugins import Plugin


@dataclass(frozen=True)
class LoadedPlugin(Plugin):
    """A plugin whose object is there."""

    thing: object = field(default=None, compare=False)

    def load(self):
        return self.thing


def add_plugins(monkeypatch, group, **things):
    """Add objects of the package my-lab 1.0 to a group, by name."""
    installed = plugins._plugins
    own = {
        name: LoadedPlugin(name, 'my-lab', '1.0', f'my_lab:{name}', thing=thing)
        for name, thing in things.items()
    }
    monkeypatch.setattr(
        plugins,
        '_plugins',
        lambda name: installed(name) | (own if name == group.name else {}),
    )
