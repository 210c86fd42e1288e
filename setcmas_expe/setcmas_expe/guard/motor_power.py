"""Switch of a TurtleBot3's motors (service motor_power)."""

from __future__ import annotations

import math

from rclpy.node import Node
from std_srvs.srv import SetBool

from setcmas_simu.fleet import topics
from setcmas_simu.ros.polling import POLLED

_AGAIN_S = 1.0


class MotorPower:
    """Asks the robot to switch its motors, off again and again: it may have been restarted."""

    def __init__(self, node: Node, service: str = topics.MOTOR_POWER) -> None:
        # An executor that serves the node would take the answers.
        self._client = node.create_client(SetBool, service, callback_group=POLLED)
        self._wanted: bool | None = None
        self._asked: tuple[int, bool | None] = (-1, None)  # the last request: its number and value
        self._next = -math.inf

    def cut(self) -> None:
        """Keep the motors off from now on: another process may switch them on."""
        self._wanted = False

    def give(self) -> None:
        """Switch the motors on, whoever switched them off."""
        self._wanted, self._next = True, -math.inf

    def leave(self) -> None:
        """Stop asking to switch them on: a stop came first."""
        if self._wanted:
            self._wanted = None

    @property
    def is_cut(self) -> bool:
        """Whether they are kept off."""
        return self._wanted is False

    @property
    def can_switch(self) -> bool:
        """Whether the robot offers the service."""
        return bool(self._client.service_is_ready())

    def step(self, now: float) -> None:
        """Take the robot's answer, and ask again when due; `now` is in s."""
        with self._client.handle:
            header, answer = self._client.handle.take_response(SetBool.Response)
        number, value = self._asked
        is_done = header and header.request_id.sequence_number == number and answer.success
        if is_done and value and self._wanted:
            self._wanted = None  # they are on
        is_new = self._wanted is not value
        if self._wanted is None or (now < self._next and not is_new) or not self.can_switch:
            return
        self._next = now + _AGAIN_S
        request = SetBool.Request(data=self._wanted)
        with self._client.handle:
            self._asked = self._client.handle.send_request(request), self._wanted
