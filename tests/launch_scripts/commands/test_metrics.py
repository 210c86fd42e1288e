import re

import numpy as np
import pytest
import yaml
from processes import refuses, run_here

from setcmas_tools.run.fleet_motion import fleet_table
from setcmas_tools.run.run_tables import write_fleet

HEADER = 't,robot,x,y,theta,v,omega\n'


@pytest.fixture
def run(tmp_path):
    """The folder of a run of two robots, 10 s, that is not of a built-in law."""
    t = np.arange(0, 101) / 10
    folder = tmp_path / 'out'
    (folder / 'csv').mkdir(parents=True)
    rows = [[ti, robot, 0.1 * ti * robot, robot, 0, 0.1, 0] for ti in t for robot in (1, 2)]
    write_fleet(fleet_table(rows), folder / 'csv' / 'fleet.csv')
    return folder


def test_the_table_and_the_file(run):
    result = run_here('metrics', 'out', cwd=run.parent)

    assert result.returncode == 0, result.stderr
    assert re.search(r'tb3_2 +2\.00', result.stdout)
    assert 'least separation: 1.00 m at 0.0 s between robots 1 and 2' in result.stdout
    content = yaml.safe_load((run / 'metrics.yaml').read_text())
    assert content['robots'][1]['path_length_m'] == 1.0
    assert content['separation']['least_separation_robots'] == [1, 2]


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (('nowhere',), "there is no 'nowhere'"),
        (('empty',), 'no fleet.csv'),
        (('damaged.csv',), "'damaged.csv'"),
        (('broken.mcap',), 'broken.mcap'),
    ],
)
def test_mistakes_are_reported_in_one_line_with_status_2(run, arguments, message):
    (run.parent / 'empty').mkdir()
    (run.parent / 'damaged.csv').write_text(f'{HEADER}0,1,0\n')
    (run.parent / 'broken.mcap').write_text('nothing of the kind')

    refuses('metrics', *arguments, message=message, cwd=run.parent)
    assert not list(run.parent.glob('**/metrics.yaml'))
