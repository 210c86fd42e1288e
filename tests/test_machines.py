"""A fleet over several machines, without multicast: one t, and what happens after faults."""

import pytest

pytest.importorskip('rclpy')

from machines import PEERS, SERVER, exact, go, recover
from network_namespaces import NoNetworkError, in_a_process


def on_three_machines(function, way, domain, folder):
    try:
        in_a_process(function, way, domain, folder)
    except NoNetworkError as error:
        pytest.skip(str(error))


def test_a_fleet_over_three_machines_shares_its_time(domain, tmp_path):
    on_three_machines(go, PEERS, domain, tmp_path)


@pytest.mark.nightly
def test_lockstep_over_a_network_that_loses_a_tenth_is_offline_to_the_last_byte(domain, tmp_path):
    on_three_machines(exact, PEERS, domain, tmp_path)


@pytest.mark.nightly
@pytest.mark.parametrize('way', [PEERS, SERVER])
def test_a_fleet_recovers_from_faults_of_one_machine(way, domain, tmp_path):
    on_three_machines(recover, way, domain, tmp_path)
