"""Round-trip time of a question over DDS to a robot's own computer."""

from __future__ import annotations

import statistics
import time

from rcl_interfaces.srv import GetParameters

from setcmas_expe.lab.model import LabRobot
from setcmas_simu.ros.process import FleetNode, RosProcess

# turtlebot3_node answers for its parameters, as every node of rclcpp does.
_SERVICE = 'turtlebot3_node/get_parameters'
_QUESTIONS = 10
_TIMEOUT_S = 1.0


def round_trip(process: RosProcess, node: FleetNode, robot: LabRobot) -> float | None:
    """Return the median time of a service call to a robot in s; None if it does not answer."""
    client = node.create_client(GetParameters, robot.topic(_SERVICE))
    try:
        if not process.spin_until(client.service_is_ready, _TIMEOUT_S):
            return None
        times = []
        for _ in range(_QUESTIONS):
            begin = time.monotonic()
            answer = client.call_async(GetParameters.Request(names=['use_sim_time']))
            if not process.spin_until(answer.done, _TIMEOUT_S):
                return None
            times.append(time.monotonic() - begin)
        return statistics.median(times)
    finally:
        node.destroy_client(client)
