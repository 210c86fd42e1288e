"""Switch of a TurtleBot3's motors (service motor_power)."""

from __future__ import annotations

import math

from rclpy.node import Node
from std_srvs.srv import SetBool

from setcmas_expe.guard.guard_watch import Power
from setcmas_simu.fleet import topics
from setcmas_simu.ros.polling import POLLED

_AGAIN_S = 1.0
_UNANSWERED = 50


class MotorPower:
    """Asks the robot to switch its motors, off again and again: it may have been restarted."""

    def __init__(self, node: Node, service: str = topics.MOTOR_POWER) -> None:
        self.power = Power.UNKNOWN
        self._wanted: Power | None = None
        # An executor that serves the node would take the answers.
        self._client = node.create_client(SetBool, service, callback_group=POLLED)
        self._asked: dict[int, Power] = {}
        self._next = -math.inf

    def cut(self) -> None:
        """Keep the motors off from now on: another process may switch them on."""
        self._wanted, self._next = Power.OFF, -math.inf

    def give(self) -> None:
        """Switch the motors on, whoever switched them off."""
        self._wanted, self._next, self.power = Power.ON, -math.inf, Power.UNKNOWN

    def leave(self) -> None:
        """Stop asking to switch them on: a stop came first."""
        if self._wanted is Power.ON:
            self._wanted = None

    @property
    def is_cut(self) -> bool:
        """Whether they are kept off."""
        return self._wanted is Power.OFF

    @property
    def can_switch(self) -> bool:
        """Whether the robot offers the service."""
        return self._client.service_is_ready()

    def step(self, now: float) -> None:
        """Take the robot's answers, and ask again when due; `now` is in s."""
        while self._take_answer():
            pass
        is_done = self._wanted in (None, self.power) and self._wanted is not Power.OFF
        if is_done or now < self._next or not self._client.service_is_ready():
            return
        self._next = now + _AGAIN_S
        assert self._wanted
        request = SetBool.Request(data=self._wanted is Power.ON)
        with self._client.handle:
            self._asked[self._client.handle.send_request(request)] = self._wanted
        if len(self._asked) > _UNANSWERED:
            del self._asked[next(iter(self._asked))]

    def _take_answer(self) -> bool:
        with self._client.handle:
            header, answer = self._client.handle.take_response(SetBool.Response)
        if header is None:
            return False
        asked = self._asked.pop(header.request_id.sequence_number, None)
        if asked and answer.success:
            self.power = asked
        return True
