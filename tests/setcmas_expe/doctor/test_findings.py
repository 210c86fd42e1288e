import pytest

from setcmas_expe.doctor.findings import (
    NOTE,
    OK,
    PROBLEM,
    Finding,
    advice_lines,
    discovery_finding,
    domain_finding,
    exit_status,
    verdict,
)

GOOD = Finding(OK, 'Python', '3.11')
KNOWN = Finding(NOTE, 'time of robots', 'off', 'set it')
BAD = [Finding(PROBLEM, f'mocap of tb3_{i}', 'silent', 'start its driver') for i in (1, 2)]


def test_problems_decide_verdict_and_exit_status():
    assert (verdict([GOOD]), exit_status([GOOD])) == ('all well', 0)
    assert (verdict([GOOD, KNOWN]), exit_status([GOOD, KNOWN])) == ('all well, with 1 note', 0)
    assert verdict([GOOD, KNOWN, *BAD]).startswith('2 problems')
    assert exit_status([GOOD, *BAD]) == 1


def test_advice_is_given_once_and_problems_come_first():
    assert advice_lines([KNOWN, GOOD, *BAD]) == [
        '- mocap of tb3_1, mocap of tb3_2: start its driver',
        '- time of robots: set it',
    ]


@pytest.mark.parametrize(
    ('values', 'level'),
    [
        ([{'ROS_DOMAIN_ID': domain} for domain in ('', '101', '232')], OK),
        ([{'ROS_DOMAIN_ID': domain} for domain in ('102', '214')], NOTE),
        ([{'ROS_DOMAIN_ID': domain} for domain in ('233', '-1', 'a')], PROBLEM),
    ],
)
def test_domains(values, level):
    assert {domain_finding(value).level for value in values} == {level}


@pytest.mark.parametrize(
    ('variables', 'level', 'text'),
    [
        ({}, OK, 'SUBNET in experiments'),
        ({'ROS_STATIC_PEERS': '10.0.0.2'}, OK, '10.0.0.2'),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCAL'}, PROBLEM, 'LOCAL'),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'OFF'}, PROBLEM, 'OFF'),
        ({'ROS_LOCALHOST_ONLY': '1'}, PROBLEM, 'ROS_LOCALHOST_ONLY'),
    ],
)
def test_discovery(variables, level, text):
    finding = discovery_finding(variables)

    assert finding.level == level
    assert text in finding.found
