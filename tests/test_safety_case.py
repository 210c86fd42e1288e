"""The tests and faults that the safety case names are there."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / 'docs/safety_case.md').read_text(encoding='utf-8')


def test_every_test_that_it_names_is_there():
    named = set(re.findall(r'`(test_\w+)`', PAGE))
    sources = [path.read_text(encoding='utf-8') for path in (ROOT / 'tests').rglob('test_*.py')]
    there = set(re.findall(r'def (test_\w+)', '\n'.join(sources)))

    assert len(named) > 15
    assert named - there == set()


def test_every_fault_that_it_names_is_in_the_benchmark():
    rows = re.findall(r'benchmark: (.*?) \|$', PAGE, re.MULTILINE)
    named = {name for row in rows for name in re.findall(r'\*(.+?)\*', row)}
    kinds = (ROOT / 'benchmarks/fault_kinds').glob('*.py')
    there = '\n'.join(path.read_text(encoding='utf-8') for path in kinds)

    assert len(named) > 15
    assert {name for name in named if name not in there} == set()
