import pytest

pytest.importorskip('rclpy')

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from setcmas_tools.player.restored_qos import restored_qos
from setcmas_tools.recorder.offered_qos import stored_qos

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
SENSOR = QoSProfile(
    depth=5, reliability=ReliabilityPolicy.BEST_EFFORT, lifespan=Duration(seconds=2)
)
USUAL = QoSProfile(depth=10)


@pytest.mark.parametrize(
    ('profiles', 'reliability', 'durability'),
    [
        ([LATCHED], 'RELIABLE', 'TRANSIENT_LOCAL'),
        ([SENSOR], 'BEST_EFFORT', 'VOLATILE'),
        ([USUAL], 'RELIABLE', 'VOLATILE'),
        ([USUAL, SENSOR], 'RELIABLE', 'VOLATILE'),
        ([], 'RELIABLE', 'VOLATILE'),
    ],
    ids=['latched', 'sensor', 'usual', 'two publishers', 'unknown'],
)
def test_who_matched_a_publisher_matches_the_player(profiles, reliability, durability):
    restored = restored_qos(stored_qos(profiles))

    assert restored.reliability == ReliabilityPolicy[reliability]
    assert restored.durability == DurabilityPolicy[durability]


def test_lifespans_are_kept():
    assert restored_qos(stored_qos([SENSOR])).lifespan.nanoseconds == 2 * 10**9
    assert restored_qos(stored_qos([USUAL])).lifespan == USUAL.lifespan
