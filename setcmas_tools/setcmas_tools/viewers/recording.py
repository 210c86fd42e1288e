"""Topics of a recording that layouts show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from setcmas_simu.fleet import topics

SERIES = {
    'x (m)': ('pose', 'pose', 'position', 'x'),
    'y (m)': ('pose', 'pose', 'position', 'y'),
    'speed (m/s)': ('twist', 'twist', 'linear', 'x'),
}
"""What is drawn over time: titles, and the fields of a robot's odometry."""


@dataclass(frozen=True)
class RecordedTopics:
    """The topics that have messages.

    Attributes:
        types: Their message types by name, such as 'nav_msgs/msg/Odometry'.
    """

    types: Mapping[str, str]

    @property
    def odometry(self) -> dict[int, str]:
        """The topic of each robot's poses, by number; motion capture goes before wheels."""
        found = {topics.robot_of(name) for name in self.types if topics.is_odometry(name)}
        return {
            robot: next(
                name
                for name in (topics.mocap_topic(robot), topics.odometry_topic(robot))
                if name in self.types
            )
            for robot in sorted(number for number in found if number)
        }

    def of_type(self, *types: str) -> list[str]:
        """Return the topics of some message types, those of robots by their numbers."""
        names = [name for name, msgtype in self.types.items() if msgtype in types]
        return sorted(names, key=lambda name: (topics.robot_of(name) or 0, name))
