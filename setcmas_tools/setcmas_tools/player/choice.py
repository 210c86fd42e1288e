"""Choice of the topics of a bag to play."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import CLOCK
from setcmas_simu.ros.messages import NoPythonTypeError, message_class
from setcmas_tools.bags.reader import Bag, BagTopic
from setcmas_tools.player.commands import is_command


class Choice:
    """The topics that are played.

    Attributes:
        classes: The message class of each.
        notes: A line for each reason for which topics are left out.
    """

    def __init__(self, bag: Bag, wanted: Sequence[str] | None, own_clock: bool) -> None:
        """Choose.

        Args:
            bag: The bag.
            wanted: Names of the topics to play; None for all.
            own_clock: Whether the player itself publishes /clock.

        Raises:
            SetcmasError: A wanted topic is not in the bag or is never played, or nothing is left.
        """
        names = {f'/{name.lstrip("/")}' for name in wanted or ()}
        if missing := names - {topic.name for topic in bag.topics}:
            raise SetcmasError(
                f'there is no topic {min(missing)} in the bag; --topics must name topics of it'
            )
        self.classes: dict[BagTopic, Any] = {}
        self._left_out: defaultdict[str, list[str]] = defaultdict(list)
        for topic in bag.topics:
            if names and topic.name not in names:
                continue
            if reason := self._objection(topic, own_clock):
                self._left_out[reason].append(topic.name)
        self.notes = [f'not played: {_listed(n)} ({why})' for why, n in self._left_out.items()]
        if not self.classes:
            raise SetcmasError('; '.join(['no topic is left to play', *self.notes]))

    def _objection(self, topic: BagTopic, own_clock: bool) -> str:
        """Return why a topic is not played; empty if it is, and keep its class."""
        if is_command(topic.name, topic.type.name):
            return 'no robot moves because of a recording'
        if own_clock and topic.name == CLOCK:
            return '--clock takes its place'
        if any(topic.name == other.name for other in self.classes):
            return 'recorded with two types'
        try:
            self.classes[topic] = message_class(topic.type.name)
        except NoPythonTypeError as error:
            return str(error)
        return ''


def _listed(names: list[str]) -> str:
    first = ', '.join(names[:3])
    return f'{first} and {len(names) - 3} more' if len(names) > 3 else first
