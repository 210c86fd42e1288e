"""Quality of service of the fleet's topics."""

from __future__ import annotations

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

STATE = QoSProfile(depth=1)
"""States of robots: reliable; only the newest matters."""

NEWEST_STATE = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
"""For receivers of states: a lost one comes again only when a newer one is there anyway."""

SENSOR = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Measurements of drivers: compatible with publishers of any reliability."""

COMMAND = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
"""Velocities: reliable, as a TurtleBot3 requires; only the newest matters."""

ROBOT_COMMAND = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, lifespan=Duration(seconds=0.2)
)
"""Velocities that are sent over a radio link: late ones are dropped, not followed.

Not for receivers: by their clock, which may differ, all commands may be late.
"""

EVENT = QoSProfile(depth=10)
"""Requests of operators, such as reset and pause: none may be lost."""

CLOCK = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
"""As ROS's own nodes subscribe to /clock."""

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Kept for late subscribers."""

LATCHED_BY_MANY = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""For subscribers of a topic on which several processes each keep a last message."""

LATCHED_VALUES = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Values from scripts: topics begin with the first value, which late recorders get, too."""

FROM_ANYBODY = (EVENT, LATCHED_BY_MANY, SENSOR)
"""For subscribers of stops: each matches publishers that the others do not, such as a button that
publishes best effort. Incompatible ones would be silent."""
