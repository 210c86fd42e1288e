from setcmas_expe.lab.findings import (
    NOTE,
    OK,
    PROBLEM,
    Finding,
    advice_lines,
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
