import numpy as np
import pytest
from metrics_runs import T, table
from runs import run_of

from setcmas_tools import simulate

pytest.importorskip('rerun')

from rerun.chunk import RrdReader

from setcmas_tools.viewers.rerun_file import write_rrd


def read(run, path):
    """Write a run, and return what rerun reads: the columns of each entity over time, and all."""
    write_rrd(run, path)
    reader = RrdReader(path)
    assert len(reader.recordings()) == len(reader.blueprints()) == 1
    chunks = reader.stream().to_chunks()
    batches = {
        chunk.entity_path: chunk.to_record_batch() for chunk in chunks if not chunk.is_static
    }
    content = {
        entity: {
            name.split(':')[-1]: batch.column(name).to_pylist() for name in batch.schema.names
        }
        for entity, batch in batches.items()
    }
    return content, {chunk.entity_path for chunk in chunks}


def seconds(column):
    return [time.total_seconds() for time in column['t']]


@pytest.fixture(scope='module')
def simulated():
    return simulate('nav_wp', nb_robots=2, duration=6, arena=(-8, 8, -8, 8))


@pytest.fixture(scope='module')
def content(simulated, tmp_path_factory):
    return read(simulated, tmp_path_factory.mktemp('rerun') / 'run.rrd')


def test_poses_are_those_of_the_run(simulated, content):
    robot = content[0]['/world/robots/tb3_2']

    track = simulated['tb3_2']
    assert seconds(robot) == pytest.approx(track.t)
    x, y, z = np.array(robot['translation']).reshape(-1, 3).T
    np.testing.assert_allclose((x, y), (track.x, track.y), atol=1e-5)
    _, _, sine, cosine = np.array(robot['quaternion']).reshape(-1, 4).T
    turned = 2 * np.arctan2(sine, cosine) - track.theta
    np.testing.assert_allclose(np.cos(turned), 1.0, atol=1e-5)
    assert not z.any()


def test_curves_are_those_of_the_metrics(simulated, content):
    values = np.ravel(content[0]['/curves/least_separation']['scalars'])
    grid = simulated.counted_grid

    np.testing.assert_allclose(values, np.hypot(*np.diff([grid.x, grid.y], axis=1)[:, 0]))
    assert '/curves/speed/tb3_1' in content[0]


def test_markers_take_the_place_of_each_other_and_borders_stay(simulated, content):
    over_time, all_of_it = content
    marker = over_time['/world/markers/tb3_1/wp_ref']
    drawn = [one for one in simulated.drawings if one.robot == 1]

    assert seconds(marker) == pytest.approx([one.t for one in drawn])
    first = drawn[0].sphere
    assert marker['positions'][0][0] == pytest.approx([first.x, first.y, first.z])
    assert marker['radii'][0][0] == pytest.approx(first.diameter / 2)
    assert '/world/borders' in all_of_it - over_time.keys()


def test_trails_have_no_line_over_a_reset(tmp_path):
    x = np.where(T < 10, 0.1 * T, 5 + 0.1 * T)
    content, _ = read(run_of(table((T, x, 0.0, 0.1))), tmp_path / 'run.rrd')

    strips = np.array(content['/world/trails/tb3_1']['strips']).reshape(-1, 2, 3)
    lengths = np.abs(strips[:, 1, 0] - strips[:, 0, 0])
    assert len(strips) == len(T) - 2
    assert lengths.max() < 0.1


def test_a_robot_of_one_pose_has_no_trail(tmp_path):
    content, _ = read(run_of(table(([0.0], 1.0, 2.0))), tmp_path / 'run.rrd')

    assert content['/world/robots/tb3_1']['translation'] == [[[1.0, 2.0, 0.0]]]
    assert '/world/trails/tb3_1' not in content
