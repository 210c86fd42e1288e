"""Quality of service as recorded in a bag, for publishers that play it."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbags.interfaces import Qos, QosDurability, QosReliability, QosTime

from setcmas_tools.player.bag_cursor import KEPT

_INFINITE_NS = 2**31 * 10**9


def is_latched(offered: Sequence[Qos]) -> bool:
    """Return whether a publisher kept messages for late subscribers."""
    return any(one.durability == QosDurability.TRANSIENT_LOCAL for one in offered)


def restored_qos(offered: Sequence[Qos]) -> QoSProfile:
    """Return a profile that matches whoever matched one of those that were offered.

    The depth is not in a bag that was recorded from the network; this one loses nothing.
    """
    best_effort = offered and all(one.reliability == QosReliability.BEST_EFFORT for one in offered)
    latched = is_latched(offered)
    return QoSProfile(
        depth=KEPT,
        reliability=ReliabilityPolicy.BEST_EFFORT if best_effort else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        deadline=_duration([one.deadline for one in offered]),
        lifespan=_duration([one.lifespan for one in offered]),
    )


def _duration(times: Sequence[QosTime]) -> Duration:
    longest = max((time.sec * 10**9 + time.nsec for time in times), default=0)
    return Duration(nanoseconds=longest if longest < _INFINITE_NS else 0)  # 0 is infinite, too
