"""What a stranger sends is read within limits, or refused in one line that names it."""

import os
import random
import re
import shutil
import warnings
from contextlib import suppress

import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_simu.yaml_entries import read_entries
from setcmas_tools.offline.offline_simulation import simulate
from setcmas_tools.page.content import run_content
from setcmas_tools.page.report_file import listings
from setcmas_tools.run.bag_conversion import convert
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_folder import find_run
from setcmas_tools.run.scenario import Scenario

LAW = """
import rviz_marker
task = 'consensus'
def control(robotNo, nbRobots, poses, t):
    rviz_marker.publish_marker(1.0, 2.0, 0.0, robotNo, color=[1, 0, 0], marker_name='wp_ref')
    return poses[0].mean() - poses[0, robotNo - 1], 0.0
"""


@pytest.fixture(scope='module')
def whole(tmp_path_factory):
    """A run with every kind of table."""
    folder = tmp_path_factory.mktemp('whole')
    (folder / 'law.py').write_text(LAW)
    run = simulate(str(folder / 'law.py'), nb_robots=3, duration=2, graph='ring', loss=0.2)
    return run.save(folder / 'run')


@pytest.fixture
def run(whole, tmp_path):
    return shutil.copytree(whole, tmp_path / 'run')


def used(path):
    """Return the lines shown while a run is read, measured and drawn; other errors are raised."""
    lines = []
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        try:
            read = Run.load(path, lines.append)
            str(read.metrics())
            list(listings(read))
            run_content(read)
        except SetcmasError as error:
            lines.append(str(error))
    assert [line for line in lines if '\n' in line or len(line) > 1000] == []
    return lines


def in_one_line(path):
    (line,) = used(path)
    return line


VALUES = (
    '', 'nan', '-inf', '1e308', '1e9', '-1', '1.5', '99999999', 'abc', '"', '\x00', '１', '0x10',
    '1_000', 'all', 'x' * 3000, '[]', '{a: {b: []}}', '1:a,2:b', '2001-01-01', '&a [*a]',
    '!!python/name:os.system', '<script>', '../../etc',
)  # fmt: skip


def damaged(text, chance):
    """Change values, lines or letters of a table or a record."""
    lines = text.splitlines()
    for _ in range(chance.choice([1, 1, 5])):
        number = chance.randrange(len(lines))
        parts = re.split('(,|: )', lines[number])
        kind = chance.randrange(6)
        if kind < 3:
            parts[chance.randrange(0, len(parts), 2)] = chance.choice(VALUES)
            lines[number] = ''.join(parts)
        elif kind == 3:
            lines[number] = ''
        elif kind == 4:
            lines += [lines[number]] * chance.randrange(50)
        else:
            lines[number] = ''.join(chance.sample(lines[number], len(lines[number])))
    return '\n'.join(lines)


def test_damaged_tables_and_records(whole, run):
    files = [*sorted((whole / 'csv').iterdir()), whole / 'run.yaml']
    chance = random.Random(1)
    for _ in range(250):
        file = chance.choice(files)
        target = run / file.relative_to(whole)
        target.write_text(damaged(file.read_text(), chance), encoding='utf-8')
        used(run)
        with suppress(SetcmasError):
            Scenario.load(run / 'run.yaml').check()
        shutil.copy(file, target)


FLEET = 't,robot,x,y,theta,v,omega\n'


def test_a_fleet_that_no_memory_holds(tmp_path):
    (tmp_path / 'fleet.csv').write_text(f'{FLEET}0,1,0,0,0,0,0\n9e5,2,0,0,0,0,0\n')

    with pytest.raises(SetcmasError, match='has 2 robots over 900000 s'):
        Run.load(tmp_path)


def test_numbers_that_no_robot_has_are_unknown_poses(tmp_path):
    (tmp_path / 'fleet.csv').write_text(f'{FLEET}0,1,1e308,-1e308,0,0,0\n0.1,1,1,2,0,0,inf\n')

    assert used(tmp_path) == []
    assert Run.load(tmp_path).table.x.tolist()[1:] == [1.0]


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('a: &a [*a]', 'nested too deep'),
        ('[' * 3000, 'nested too deep'),
        ('- ' * 200 + '1', 'nested too deep'),
        ('a: &a [x,x,x,x,x,x,x,x,x,x]\n' + ''.join(
            f'{"abcdefghij"[i + 1]}: &{"abcdefghij"[i + 1]} '
            f'[{",".join(["*" + "abcdefghij"[i]] * 10)}]\n' for i in range(9)
        ), 'more than 200,000 values'),
        ('? [1, 2]\n: 3', 'line 1: a key must be a text'),
        ('a: ' + '9' * 5000, 'more than 100 digits'),
        ('a: 0x' + 'f' * 5000, 'more than 100 digits'),
        ('k' * 800 + ': 1', 'more than 500 letters'),
        ('# ' + 'x' * 2_000_000, 'at most 1,000,000 bytes'),
        ('a: !!bool x\n', "line 1: 'x' does not suit its tag"),
        ('a: !!int ""\n', 'does not suit its tag'),
        ('a: !!timestamp x\n', 'does not suit its tag'),
    ],
)  # fmt: skip
def test_yaml_beyond_the_limits(tmp_path, text, words):
    file = tmp_path / 'strange.yaml'
    file.write_text(text)

    with pytest.raises(SetcmasError, match=words) as caught:
        read_entries(file)
    assert str(file) in str(caught.value)


@pytest.mark.skipif(not hasattr(os, 'mkfifo'), reason='pipes with names are POSIX')
@pytest.mark.parametrize('name', ['run.yaml', 'csv/fleet.csv', 'csv/task.json'])
@pytest.mark.parametrize('kind', ['pipe', 'device', 'ten gigabytes'])
def test_a_file_that_has_no_end(run, name, kind):
    path = run / name
    path.unlink()
    if kind == 'pipe':
        os.mkfifo(path)
    elif kind == 'device':
        path.symlink_to('/dev/zero')
    else:
        with path.open('wb') as file:
            file.truncate(10**10)

    if name == 'csv/fleet.csv' and kind != 'ten gigabytes':  # it is none, and there is no bag
        assert 'there is no fleet.csv' in in_one_line(run)
    else:
        words = (
            'is too large; it must have at most' if kind == 'ten gigabytes' else 'not a regular'
        )
        assert str(path) in in_one_line(run)
        assert words in in_one_line(run)


@pytest.mark.parametrize('name', ['model', 'arena', 'obstacles', 'algo', 'graph', 'poses'])
def test_values_of_another_kind_hinder_no_report(run, name):
    text = (run / 'run.yaml').read_text()
    for value in (7, [1, 2], [[1]], {'a': 1}, 'x', 'null'):
        changed, count = re.subn(rf'(?m)^  {name}: .*', f'  {name}: {value}', text)
        assert count == 1
        (run / 'run.yaml').write_text(changed)

        used(run)


def test_a_robot_beyond_the_largest_fleet_is_none(tmp_path, write_bag, make):
    odometry = make('nav_msgs/msg/Odometry', {'pose.pose.orientation.w': 1.0})
    names = ('/tb3_1/odom', '/tb3_1000000000000000/odom', '/tb3_2001/odom')
    bag = write_bag(
        tmp_path / 'bag', [(name, i / 10, odometry) for i in range(20) for name in names]
    )

    assert used(bag) == []
    assert Run.load(bag).robots == [1]
    assert len(convert(bag).files) == 3
    assert find_run(bag).bag == bag
