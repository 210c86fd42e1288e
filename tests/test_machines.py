"""A fleet over several machines, without multicast, of which one loses its link for a while."""

import pytest

pytest.importorskip('rclpy')

from machines import recover_from_a_cut_link
from network_namespaces import on_a_network


@pytest.mark.nightly
def test_robots_of_a_machine_that_was_cut_off_stop_and_go_on(domain, tmp_path):
    on_a_network(recover_from_a_cut_link, domain, tmp_path)
