"""Pause and emergency stop of a simulated fleet: /pause, a service, and /emergency_stop."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node
from std_msgs.msg import Bool
from std_srvs.srv import SetBool

from setcmas_ctrl.driving.si_to_uni import SiToUni
from setcmas_simu.fleet import topics
from setcmas_simu.reports.launcher import Launcher
from setcmas_simu.reports.reports import Paused
from setcmas_simu.ros import qos


class FleetPause:
    """Pauses robots, or lets them go on; tells the launcher, as it may come from elsewhere."""

    def __init__(
        self, node: Node, followers: Sequence[SiToUni], launcher: Launcher, in_lockstep: bool
    ) -> None:
        """Listen through a node, whose name the service bears; a pause in lockstep stops time."""
        self._followers = followers
        self._launcher = launcher
        self._stopped = False
        if not in_lockstep:
            node.create_subscription(Bool, topics.FLEET_PAUSE, self._on_pause, qos.EVENT)
            node.create_service(SetBool, '~/pause', self._answer)
        for profile in (qos.EVENT, qos.LATCHED):  # each matches publishers that the other does not
            node.create_subscription(Bool, topics.EMERGENCY_STOP, self._on_stop, profile)

    def _on_stop(self, message: Bool) -> None:
        if message.data and not self._stopped:
            self._pause(True, topics.EMERGENCY_STOP)
            print('emergency stop: it ends with this process', flush=True)
            self._stopped = True
            for follower in self._followers:
                follower.stopped = True

    def _on_pause(self, message: Bool) -> None:
        self._pause(message.data, '/pause')

    def _pause(self, paused: bool, by: str) -> None:
        if self._stopped:
            return
        if any(follower.paused != paused for follower in self._followers):
            print(f'{"paused" if paused else "started"} by {by}', flush=True)
            self._launcher.report(Paused(paused))
        for follower in self._followers:
            follower.pause(paused)

    def _answer(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._pause(request.data, 'service')
        response.success = request.data or not self._stopped
        paused = request.data or self._stopped
        response.message = f'all robots are {"paused" if paused else "let go"}'
        return response
