"""Quality of service of the fleet's topics."""

from __future__ import annotations

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

STATE = QoSProfile(depth=1)
"""Robots' states: reliable, only the newest matters."""

SENSOR = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Measurements of drivers: matches publishers of any reliability."""

COMMAND = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
"""Velocities: reliable because a TurtleBot3 asks for it; an older command is never of use."""

ROBOT_COMMAND = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, lifespan=Duration(seconds=0.2)
)
"""Velocities over a radio link: one that was held up is dropped, not followed late."""

LOCKSTEP_STATE = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Robots' states in lockstep: who subscribes gets those of now, and a recorder all of them."""

LOCKSTEP_COMMAND = QoSProfile(depth=100)
"""What laws send in lockstep: a recorder gets all of it."""

EVENT = QoSProfile(depth=10)
"""Wishes of people, such as reset and pause: none of them may be lost."""

CLOCK = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
"""As ROS's own nodes listen to /clock."""

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Kept for those who subscribe late."""

LATCHED_BY_MANY = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""For who listens to a topic on which several processes keep something: the last of each."""
