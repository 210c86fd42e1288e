"""Other nodes that command robots, or pretend to be part of the experiment."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import Point32, TwistStamped
from nav_msgs.msg import Odometry
from rehearsal import Rehearsal
from std_msgs.msg import Bool

from fault_kinds.kind import Kind, falls_silent, sends
from setcmas_simu.ros import qos

_MODULE = 'setcmas_ctrl.controllers.controller_processes'
_CTRL = [sys.executable, '-m', _MODULE, '--algo', 'consensus']


def _drive(V: float = 0.2) -> TwistStamped:
    message = TwistStamped()
    message.twist.linear.x = V
    return message


def _odometry() -> Odometry:
    message = Odometry()
    message.pose.pose.position.x = 1.0
    message.pose.pose.orientation.w = 1.0
    return message


def _sends(topic: str, message: Any, line: str, **how: Any) -> Kind:
    return Kind(lambda r: sends(r, topic, message, **how), line, falls_silent)


def _starts(command: list[str]) -> Callable[[Rehearsal], float]:
    """Return what starts a second command, and waits until the robots notice it."""

    def start(r: Rehearsal) -> float:
        r.commands.append(
            subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        )
        r.peer.wait_for(lambda: any(truth[-1].rolls == 0.0 for truth in r.truth.values()))
        return next(t[-1].stamp for t in r.truth.values() if t[-1].rolls == 0.0)

    return start


def _ends(r: Rehearsal) -> None:
    for command in r.commands:
        command.terminate()
        command.wait(20)


def _after_a_stop(kind: Kind) -> Kind:
    """Return a fault that begins when robots are paused: nothing may move."""

    def inject(r: Rehearsal) -> float:
        paused = r.press(' ')
        r.peer.spin(2.0)
        kind.inject(r)
        return paused

    return Kind(inject, kind.line, kind.undo)


KINDS = {
    'another node on cmd_vel': _sends('/tb3_1/cmd_vel', _drive(), 'commands it|command it'),
    'another node on cmd_vel, 200 Hz': _sends(
        '/tb3_1/cmd_vel', _drive(), 'commands it|command it', rate=200
    ),
    'another node on cmd_vel_wanted': _sends(
        '/tb3_1/cmd_vel_wanted', _drive(), 'controllers command it'
    ),
    'another node on cmd_vel_guarded': _sends(
        '/tb3_1/cmd_vel_guarded', _drive(), 'past its guard'
    ),
    'commands while paused': _after_a_stop(_sends('/tb3_1/cmd_vel', _drive(), '')),
    'guarded commands while paused': _after_a_stop(_sends('/tb3_1/cmd_vel_guarded', _drive(), '')),
    'false on /pause while paused': _after_a_stop(_sends('/pause', Bool(), '', rate=1)),
    'false on /tb3_1/pause while paused': _after_a_stop(
        _sends('/tb3_1/pause', Bool(), '', rate=1)
    ),
    'false on /paused while paused': _after_a_stop(_sends('/paused', Bool(), '', qos=qos.STATE)),
    'another node on /paused': _sends('/paused', Bool(), 'paused', qos=qos.STATE),
    'poses on the topic of the bridge': _sends('/mocap/tb3_1/odom', _odometry(), 'else|send'),
    'poses on the topic of motion capture': _sends(
        '/qualisys/tb3_1/odom', _odometry(), 'nodes send it'
    ),
    'a second controller': Kind(
        _starts([*_CTRL, '--nb-robots', '2']), 'commands it|command it', _ends
    ),
    'velocities on cmd_cart_vel while paused': _after_a_stop(
        _sends('/tb3_1/cmd_cart_vel', Point32(x=0.2), '')
    ),
}
