"""Pause and stop of the controllers of simulated robots.

In experiments they follow the pause node (`setcmas_ctrl/pause_watch.py`).
"""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node
from std_msgs.msg import Bool
from std_srvs.srv import SetBool

from setcmas_ctrl.si_to_uni_node import SiToUni
from setcmas_simu.fleet import topics
from setcmas_simu.reports import Launcher, Paused
from setcmas_simu.ros import qos
from setcmas_simu.ros.polling import PolledTopic


class FleetPause:
    """Pauses and resumes robots, and reports it to the launcher.

    Attributes:
        topics: Its topics, to be taken often.
    """

    def __init__(self, node: Node, drivers: Sequence[SiToUni], launcher: Launcher) -> None:
        """Subscribe and offer the service through a node."""
        self._drivers = drivers
        self._launcher = launcher
        self._stopped = self._requested = False
        node.create_service(SetBool, '~/pause', self._answer)
        stop = topics.EMERGENCY_STOP
        self.topics = [
            PolledTopic(node, Bool, topics.FLEET_PAUSE, self._on_pause, qos.EVENT),
            *(PolledTopic(node, Bool, stop, self._on_stop, one) for one in qos.FROM_ANYBODY),
        ]

    @property
    def is_on(self) -> bool:
        """Whether all robots are paused."""
        if not self._drivers:  # controllers whose robots other processes drive
            return self._requested
        return all(driver.paused for driver in self._drivers)

    def _on_stop(self, message: Bool) -> None:
        if message.data and not self._stopped:
            self._pause(True, topics.EMERGENCY_STOP)
            print('stopped by /emergency_stop: restart this process to continue', flush=True)
            self._stopped = True
            for driver in self._drivers:
                driver.stopped = True

    def _on_pause(self, message: Bool) -> None:
        self._pause(message.data, '/pause')

    def _pause(self, paused: bool, by: str) -> None:
        if self._stopped:
            return
        if self._requested != paused or any(one.paused != paused for one in self._drivers):
            print(f'{"paused" if paused else "started"} by {by}', flush=True)
            self._launcher.report(Paused(paused))
        self._requested = paused
        for driver in self._drivers:
            driver.pause(paused)

    def _answer(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._pause(request.data, 'service')
        response.success = request.data or not self._stopped
        paused = request.data or self._stopped
        response.message = f'all robots are {"paused" if paused else "resumed"}'
        return response
