"""A fleet over several machines, without multicast: one t, and what happens after faults."""

import pytest

pytest.importorskip('rclpy')

from machines import go, recover
from network_namespaces import on_a_network


def test_a_fleet_over_three_machines_shares_its_time(domain, tmp_path):
    on_a_network(go, domain, tmp_path)


@pytest.mark.nightly
def test_a_fleet_recovers_from_faults_of_one_machine(domain, tmp_path):
    on_a_network(recover, domain, tmp_path)
