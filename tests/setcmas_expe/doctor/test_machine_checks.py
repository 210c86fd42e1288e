import pytest

from setcmas_expe.doctor import machine_checks
from setcmas_expe.doctor.findings import OK, PROBLEM
from setcmas_expe.doctor.machine_checks import (
    discovery_finding,
    domain_finding,
    python_finding,
)


@pytest.mark.parametrize(
    ('check', 'values', 'level'),
    [
        (python_finding, [(3, 10), (3, 13)], OK),
        (python_finding, [(3, 9), (3, 14)], PROBLEM),
        (domain_finding, [{'ROS_DOMAIN_ID': domain} for domain in ('', '101')], OK),
        (domain_finding, [{'ROS_DOMAIN_ID': domain} for domain in ('102', '-1', 'a')], PROBLEM),
    ],
)
def test_pythons_and_domains(check, values, level):
    assert {check(value).level for value in values} == {level}


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


def test_a_plugin_in_an_unknown_group_is_a_finding(monkeypatch):
    monkeypatch.setattr(machine_checks, 'unknown_groups', lambda: {'setcmas.metric': ['my-lab']})

    (finding,) = machine_checks.plugin_findings()

    assert finding.level == PROBLEM
    assert finding.found == 'my-lab has entry points in the unknown group setcmas.metric'
    assert finding.advice.endswith('did you mean setcmas.metrics?')
