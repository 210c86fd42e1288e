"""Start of a controller process: what must be there before its laws are called."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from setcmas_ctrl.driving.odometry import FleetOdometry
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.fleet.topics import TRIG_ODOM, robot_topic
from setcmas_simu.ros.process import RosProcess
from setcmas_simu.ros.step_loop import Clock

if TYPE_CHECKING:
    from setcmas_ctrl.controller.network_links import FleetCommunication

_REMIND_EVERY_S = 2.0
_LOOK_EVERY_S = 0.002
_AFTER_ODOMETRY_S = 0.02

Warn = Callable[[str], None]
Take = Callable[[], object]
"""Takes what has come."""


def wait_for_poses(
    process: RosProcess, odometry: FleetOdometry, take: Take, warn: Warn, experiment: bool
) -> None:
    """Wait until the pose of every robot is known, and say whose is not.

    Args:
        process: Is served meanwhile.
        odometry: The poses of the fleet.
        take: Takes them as they come.
        warn: Shows a message to the user.
        experiment: Whether poses come from motion capture.
    """
    source = 'does motion capture see all' if experiment else 'is their simulator running'
    _wait(
        process,
        take,
        odometry.missing,
        lambda missing: warn(
            f'waiting for the odometry of {robots_in_words(missing)} '
            f'({odometry.topic_of(missing[0])}); {source}?'
        ),
    )


def wait_for_states(
    process: RosProcess, communication: FleetCommunication, take: Take, warn: Warn
) -> None:
    """Wait until every robot that sends its state when triggered has sent one."""
    _wait(
        process,
        take,
        communication.missing,
        lambda missing: warn(
            f'waiting for the states of {robots_in_words(missing)} '
            f'({robot_topic(missing[0], TRIG_ODOM)}); '
            'is their controller running with --event-triggered?'
        ),
    )


def _wait(
    process: RosProcess,
    take: Take,
    missing: Callable[[], list[int]],
    remind: Callable[[list[int]], None],
) -> None:
    def complete() -> bool:
        take()
        return not missing()

    while not process.spin_until(complete, _REMIND_EVERY_S) and not process.stopping:
        remind(missing())


def fall_in_step(
    process: RosProcess, odometry: FleetOdometry, take: Take, robot: int, clock: Clock
) -> None:
    """Wait until shortly after the next odometry of a robot.

    Robots and laws step on clocks that go alike, at rates that divide each other, so that from
    then on every call sees fresh poses, and its commands arrive before the robots' next step.
    """
    take()

    def is_new() -> bool:
        take()
        return odometry.age(robot) == 0.0

    process.spin_until(is_new, 1.0, _LOOK_EVERY_S)
    begin = clock.now()
    process.spin_until(lambda: clock.now() - begin >= _AFTER_ODOMETRY_S, 1.0, _LOOK_EVERY_S)
