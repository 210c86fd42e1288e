"""Things of a package of somebody else's, without its installation."""

from types import SimpleNamespace

from setcmas_simu import doors
from setcmas_simu.doors import Offer


def offer(monkeypatch, door, **things):
    """Let the package my-lab 1.0 offer things by name at a door."""
    offers = doors._offers
    own = {
        name: Offer(name, 'my-lab', '1.0', SimpleNamespace(load=lambda thing=thing: thing))
        for name, thing in things.items()
    }
    monkeypatch.setattr(
        doors, '_offers', lambda group: offers(group) | (own if group == door.group else {})
    )
