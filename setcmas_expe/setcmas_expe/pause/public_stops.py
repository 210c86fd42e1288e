"""Topics and services with which every process may stop the robots, and none start them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from setcmas_expe.guard.guard_decision import GuardState
from setcmas_expe.guard.guard_watch import reported
from setcmas_expe.lab.lab import Lab
from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos

_WHO_STARTS = 'press s in the terminal of the experiment, or start on its joystick'


@dataclass(frozen=True)
class Stops:
    """Actions of the pause node; each takes how it was asked."""

    pause: Callable[[str], None]
    emergency: Callable[[str], None]
    take_over: Callable[[str], None]  # of the stop of a guard
    hint: Callable[[str], None]  # why nothing was done


class PublicStops:
    """Listens to /pause, to /emergency_stop and its service, and to the guards."""

    def __init__(self, node: Node, lab: Lab, stops: Stops) -> None:
        """Listen through a node; the service is in its namespace."""
        self._stops = stops
        node.create_subscription(Bool, topics.FLEET_PAUSE, self._on_pause, qos.EVENT)
        for profile in (qos.EVENT, qos.LATCHED_BY_MANY):  # each matches other publishers
            node.create_subscription(Bool, topics.EMERGENCY_STOP, self._on_stop, profile)
        for robot in lab.robots:
            node.create_subscription(
                DiagnosticStatus,
                robot.topic(topics.GUARD_STATE),
                partial(self._on_guard, robot.number),
                qos.STATE,
            )
        node.create_service(Trigger, '~/emergency_stop', self._answer_stop)

    def _on_pause(self, message: Bool) -> None:
        if message.data:
            self._stops.pause(f'by {topics.FLEET_PAUSE}')
        else:
            nothing = f'false on {topics.FLEET_PAUSE} starts nothing in an experiment'
            self._stops.hint(f'{nothing}: {_WHO_STARTS}')

    def _on_stop(self, message: Bool) -> None:
        if message.data:
            self._stops.emergency(f'by {topics.EMERGENCY_STOP}')
        else:
            self._stops.hint(f'false on {topics.EMERGENCY_STOP} releases nothing: press R twice')

    def _on_guard(self, robot: int, status: DiagnosticStatus) -> None:
        if reported(status).state is GuardState.EMERGENCY:
            self._stops.take_over(f'held by the guard of robot {robot}')

    def _answer_stop(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._stops.emergency('by service')
        response.success, response.message = True, 'stopped'
        return response
