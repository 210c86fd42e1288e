"""Commands of the page to running robots, and the name of their control law."""

from __future__ import annotations

from rcl_interfaces.srv import GetParameters
from rclpy.client import Client
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.task import Future
from std_msgs.msg import Bool, Empty

from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos
from setcmas_simu.ros.process import RosProcess
from setcmas_tools.page.live import LiveRun
from setcmas_tools.page.server import Action, Pause, Stop

_PARAMETERS = f'/{topics.CONTROLLERS}/get_parameters'


class FleetCommands:
    """Publishes pause, reset and emergency stop.

    The publishers are made when a page is open: every recorded run would have their topics.
    """

    def __init__(self, node: Node) -> None:
        """Prepare; nothing is published before `prepare`."""
        self._node = node
        self._pause: Publisher | None = None
        self._reset: Publisher | None = None
        self._stop: Publisher | None = None
        self._subscribers = 0

    def prepare(self) -> None:
        """Make the publishers, so that subscribers know them when a button is pressed."""
        if self._pause is None:
            self._pause = self._node.create_publisher(Bool, topics.FLEET_PAUSE, qos.EVENT)
            self._reset = self._node.create_publisher(Empty, topics.FLEET_RESET, qos.EVENT)
            self._stop = self._node.create_publisher(Bool, topics.EMERGENCY_STOP, qos.EVENT)

    def obey(self, action: Action, real: bool) -> None:
        """Do what a button asks for; real robots are paused and stopped only.

        The pause node of an experiment starts robots for its own terminal, whatever is published.
        """
        if isinstance(action, Stop):
            self.stop()
        elif isinstance(action, Pause):
            self.pause(action.on or real)
        elif not real:
            self.reset()

    def pause(self, paused: bool) -> None:
        """Pause the robots (True), or start those of a simulation."""
        if self._pause:
            self._pause.publish(Bool(data=paused))

    def stop(self) -> None:
        """Stop all robots at once, until an operator releases them."""
        if self._stop:
            self._stop.publish(Bool(data=True))

    def reset(self) -> None:
        """Put simulated robots back to their start poses."""
        if self._reset:
            self._reset.publish(Empty())

    def follow_subscribers(self, paused: bool) -> None:
        """Repeat a pause that still holds for controllers that are new since the last call."""
        if self._pause is None:
            return
        subscribers = self._pause.get_subscription_count()
        if paused and subscribers > self._subscribers:
            self._pause.publish(Bool(data=True))
        self._subscribers = subscribers


class LawName:
    """Name of the control law, which each new process of controllers is asked for once."""

    def __init__(self, process: RosProcess, node: Node, run: LiveRun) -> None:
        """Prepare; nothing is asked before `look`."""
        process.add(node)
        self._process = process
        self._node = node
        self._run = run
        self._client: Client | None = None
        self._answer: Future | None = None

    def look(self) -> None:
        """Ask, or take the answer; once a second is enough."""
        if not self._node.count_services(_PARAMETERS):
            if self._client:
                self._node.destroy_client(self._client)
            self._client = self._answer = None
        elif not self._client:
            self._client = self._node.create_client(GetParameters, _PARAMETERS)
        elif not self._answer and self._client.service_is_ready():
            self._answer = self._client.call_async(GetParameters.Request(names=[topics.LAW]))
            self._answer.add_done_callback(self._take)
        self._process.serve(0.0)

    def _take(self, answer: Future) -> None:
        values = answer.result().values
        self._run.law = values[0].string_value if values else ''
