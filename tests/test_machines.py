"""A fleet over several machines, without multicast: one t, and what happens after faults."""

import pytest

pytest.importorskip('rclpy')

from machines import recover
from network_namespaces import on_a_network


@pytest.mark.nightly
def test_a_fleet_shares_its_time_and_recovers_from_faults_of_one_machine(domain, tmp_path):
    on_a_network(recover, domain, tmp_path)
