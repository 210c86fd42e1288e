"""Whoever may stop robots: at the terminal, by joystick, over topics."""

from __future__ import annotations

import time

from rehearsal import Rehearsal
from sensor_msgs.msg import Joy
from std_msgs.msg import Bool

from fault_kinds.kind import Kind, falls_silent
from setcmas_simu.ros import qos


def _joystick(r: Rehearsal, last: list[int], seconds: float = 1.5) -> float:
    """Send a joystick's messages for a while, the last ones with some buttons down."""
    joystick = r.peer.node.create_publisher(Joy, '/joy', 10)
    r.others.append(joystick)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        joystick.publish(Joy(buttons=[0] * 11, axes=[0.0] * 8))
        now = time.time()
        r.peer.spin(0.05)
    if last:
        buttons = [int(button in last) for button in range(11)]
        now = time.time()
        for _ in range(10):
            joystick.publish(Joy(buttons=buttons, axes=[0.0] * 8))
            r.peer.spin(0.05)
    return now


def _says(topic: str) -> Kind:
    def send(r: Rehearsal) -> float:
        publisher = r.peer.publisher(Bool, topic, qos=qos.LATCHED)
        r.others.append(publisher)
        publisher.publish(Bool(data=True))
        return time.time()

    return Kind(send, f'{topic}|STOP by', falls_silent)


KINDS = {
    'space bar': Kind(lambda r: r.press(' '), 'paused: by space bar'),
    'Esc': Kind(lambda r: r.press('\x1b'), 'STOP by'),
    'e': Kind(lambda r: r.press('e'), 'STOP by'),
    'q': Kind(lambda r: r.press('q'), ''),
    'joystick gone': Kind(lambda r: _joystick(r, []), 'joystick has disappeared'),
    'joystick, any other button': Kind(lambda r: _joystick(r, [2]), 'STOP by'),
    'true on /pause': _says('/pause'),
    'true on /emergency_stop': _says('/emergency_stop'),
}
