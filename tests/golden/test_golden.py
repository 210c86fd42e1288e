"""Runs, tables and marks are equal to the golden files; store.py stores them again.

Processors and versions of numpy differ in the last bit, so numbers may differ in their last digit.
"""

import re

import numpy as np
import pytest
from golden import store
from sandboxes import needs_sandbox

NUMBER = re.compile(rb'-?\d+\.\d+(?:e[-+]\d+)?')


def same(made, golden):
    """Return whether a file is the golden one, up to the last digit of its numbers."""
    if NUMBER.sub(b'#', made) != NUMBER.sub(b'#', golden):
        return False
    numbers = (np.array(NUMBER.findall(file), float) for file in (made, golden))
    return np.allclose(*numbers, rtol=1.1e-9, atol=1.1e-9)


def compare(made, name):
    golden = store.stored(name)
    differ = [file for file in golden if file not in made or not same(made[file], golden[file])]
    for file in differ[:1]:  # pytest shows the lines
        assert made.get(file, b'').decode() == golden[file].decode(), f'{name}: {differ}'


@pytest.mark.parametrize('name', store.RUNS)
def test_an_offline_run_is_the_golden_one(name, tmp_path):
    made = store.run(name, tmp_path)
    compare(made, name)
    assert made.keys() == store.stored(name).keys()


@pytest.mark.parametrize(('name', 'golden'), store.BAGS.items())
def test_tables_of_a_bag_are_the_golden_ones(name, golden, tmp_path):
    made = store.bag_tables(name, tmp_path)
    compare(made, golden)
    assert made.keys() == store.stored(golden).keys()


def test_the_table_of_a_sweep_is_the_golden_one(tmp_path):
    compare(store.sweep_table(tmp_path), 'sweep')


@needs_sandbox
@pytest.mark.nightly
def test_marks_of_a_class_are_the_golden_ones(tmp_path):
    compare(store.marks(tmp_path), 'marks')
