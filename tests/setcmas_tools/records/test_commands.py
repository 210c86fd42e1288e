import numpy as np

from setcmas_tools.records.commands import commands, read_csv, with_allowed, write_csv

WANTED = np.array([[0.0, 1, 0.5, 0.1], [0.0, 2, 0.4, 0.0], [0.2, 1, 0.3, 0.2], [0.2, 2, 0.1, 0.0]])


def test_what_a_filter_allowed_stands_beside_its_command():
    allowed = np.array([[0.201, 1, 0.1, 0.0, 2], [0.001, 2, 0.0, 0.0, 1]])

    rows = with_allowed(WANTED, allowed)

    assert rows[:, 4:].tolist() == [[0.5, 0.1, 0], [0, 0, 1], [0.1, 0, 2], [0.1, 0, 0]]


def test_a_file_keeps_what_was_allowed(tmp_path):
    given = commands(np.column_stack([WANTED, WANTED[:, 2:], [0, 1, 2, 3]]))
    write_csv(given, tmp_path / 'commands.csv')

    read = read_csv(tmp_path / 'commands.csv')

    assert read.of(2).allowed.verdict.tolist() == [1, 3]
    assert read.allowed.vx.tolist() == given.allowed.vx.tolist()
