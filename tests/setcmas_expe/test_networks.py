"""Motion capture, laptop and robots on machines of their own, without multicast."""

import pytest

pytest.importorskip('rclpy')

from network_namespaces import NoNetworkError, in_a_process
from network_rehearsal import (
    PEERS,
    SERVER,
    record_robots_with_another_clock,
    roll_after_the_laptop_is_cut_off,
)

from setcmas_tools.compare.latency import CAMERA, MOTION, fleet_latency
from setcmas_tools.run.run import Run

WAY = 0.16  # m
NB_ROBOTS = 2


@pytest.mark.parametrize('way', [PEERS, pytest.param(SERVER, marks=pytest.mark.nightly)])
@pytest.mark.nightly
def test_robots_over_a_network_whose_plug_is_pulled(way, domain, tmp_path):
    try:
        ways = in_a_process(roll_after_the_laptop_is_cut_off, way, NB_ROBOTS, domain, tmp_path)
    except NoNetworkError as error:
        pytest.skip(str(error))

    assert len(ways) == NB_ROBOTS
    assert max(ways) < WAY


MODEL = (
    'limits: burger\nothers: {forward: {lag: 0.2, delay: 0.15}, turn: {lag: 0.2, delay: 0.15}}\n'
)


@pytest.mark.nightly
@pytest.mark.alone
def test_latency_of_robots_whose_clock_is_3_s_behind(domain, tmp_path):
    model = tmp_path / 'model.yaml'
    model.write_text(MODEL)
    try:
        bag = in_a_process(
            record_robots_with_another_clock,
            *(-3, ['--model', str(model)], NB_ROBOTS, domain, tmp_path),
        )
    except NoNetworkError as error:
        pytest.skip(str(error))

    found = fleet_latency(Run.load(bag))
    for robot, parts in found.parts.items():
        ahead, doubt = found.clocks[robot]
        assert abs(ahead + 3.0) <= doubt < 0.01
        assert 0.01 < parts[CAMERA].median_s < 0.03
        for name, part in parts.items():
            assert part, name
        assert parts[MOTION].median_s == pytest.approx(0.35, abs=0.01)
