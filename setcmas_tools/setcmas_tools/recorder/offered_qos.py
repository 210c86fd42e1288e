"""Quality of service that publishers offer: how to subscribe to it, and how a bag stores it."""

from __future__ import annotations

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)

DEPTH = 1000
"""Messages of a topic that may wait to be written: a second of the fastest motion capture."""


def subscription_qos(reliable: bool, transient_local: bool) -> QoSProfile:
    """Return the profile of a subscription that loses as little as its publishers allow."""
    return QoSProfile(
        depth=DEPTH,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=(
            DurabilityPolicy.TRANSIENT_LOCAL if transient_local else DurabilityPolicy.VOLATILE
        ),
    )


def are_reliable(profiles: list[QoSProfile]) -> bool:
    """Return whether all publishers offer reliable delivery."""
    return all(profile.reliability == ReliabilityPolicy.RELIABLE for profile in profiles)


def are_transient_local(profiles: list[QoSProfile]) -> bool:
    """Return whether all publishers keep messages for late subscribers."""
    return all(profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for profile in profiles)


def stored_qos(profiles: list[QoSProfile]) -> list[Qos]:
    """Return the different profiles of a topic's publishers in the terms of rosbags."""
    return list(dict.fromkeys(_stored(profile) for profile in profiles))


def _stored(profile: QoSProfile) -> Qos:
    return Qos(
        QosHistory[profile.history.name],
        profile.depth,
        QosReliability[profile.reliability.name],
        QosDurability[profile.durability.name],
        _time(profile.deadline),
        _time(profile.lifespan),
        QosLiveliness[profile.liveliness.name],
        _time(profile.liveliness_lease_duration),
        profile.avoid_ros_namespace_conventions,
    )


def _time(duration: Duration) -> QosTime:
    return QosTime(*divmod(duration.nanoseconds, 10**9))
