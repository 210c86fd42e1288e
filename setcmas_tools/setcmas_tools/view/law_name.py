"""Name of the control law, asked of the process of the controllers."""

from __future__ import annotations

from rcl_interfaces.srv import GetParameters
from rclpy.client import Client
from rclpy.node import Node
from rclpy.task import Future

from setcmas_simu.fleet import topics
from setcmas_simu.ros.process import RosProcess
from setcmas_tools.view.model.fleet_state import FleetState

_SERVICE = f'/{topics.CONTROLLERS}/get_parameters'


class LawName:
    """Asks once whenever controllers have come, and puts the answer into the state."""

    def __init__(self, process: RosProcess, node: Node, state: FleetState) -> None:
        """Prepare; nothing is asked before `look`."""
        process.add(node)
        self._process = process
        self._node = node
        self._state = state
        self._client: Client | None = None
        self._answer: Future | None = None

    def look(self) -> None:
        """Ask, or take the answer; once a second is enough."""
        if not self._node.count_services(_SERVICE):
            if self._client:
                self._node.destroy_client(self._client)
            self._client = self._answer = None
        elif not self._client:
            self._client = self._node.create_client(GetParameters, _SERVICE)
        elif not self._answer and self._client.service_is_ready():
            self._answer = self._client.call_async(GetParameters.Request(names=[topics.LAW]))
            self._answer.add_done_callback(self._take)
        self._process.serve(0.0)

    def _take(self, answer: Future) -> None:
        values = answer.result().values
        self._state.law = values[0].string_value if values else ''
