"""A fleet over several machines, without multicast: one t, and what happens after faults."""

import pytest

pytest.importorskip('rclpy')

from machines import exact, go, recover
from network_namespaces import NoNetworkError, in_a_process


def on_three_machines(function, domain, folder):
    try:
        in_a_process(function, domain, folder)
    except NoNetworkError as error:
        pytest.skip(str(error))


def test_a_fleet_over_three_machines_shares_its_time(domain, tmp_path):
    on_three_machines(go, domain, tmp_path)


@pytest.mark.nightly
def test_lockstep_over_a_network_that_loses_a_tenth_is_offline_to_the_last_byte(domain, tmp_path):
    on_three_machines(exact, domain, tmp_path)


@pytest.mark.nightly
def test_a_fleet_recovers_from_faults_of_one_machine(domain, tmp_path):
    on_three_machines(recover, domain, tmp_path)
