import numpy as np
import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.start_poses import RandomPoses, given_poses, parse_pose_option


@pytest.mark.parametrize(
    ('text', 'pose'),
    [('3:1.0,2.0,1.57', (3, (1.0, 2.0, 1.57))), ('1:-5, 5', (1, (-5.0, 5.0, 0.0)))],
)
def test_pose_option(text, pose):
    assert parse_pose_option(text) == pose


@pytest.mark.parametrize(
    'text',
    ['', '1', '1:', '0:1,2,3', 'a:1,2,3', '1:1', '1:1,2,3,4', '1:nan,0,0', '1:x,y', '1:1,inf'],
)
def test_malformed_pose_options_are_refused(text):
    with pytest.raises(SetcmasError, match='must be'):
        parse_pose_option(text)


@pytest.mark.parametrize(
    'content',
    ['[[1, 2, 3], [4, 5]]', '{1: [1, 2, 3], 2: [4, 5]}', 'tb3_1: [1, 2, 3]\ntb3_2: [4, 5]\n'],
)
def test_poses_file(tmp_path, content):
    path = tmp_path / 'poses.yaml'
    path.write_text(content)

    assert given_poses(2, path) == {1: (1.0, 2.0, 3.0), 2: (4.0, 5.0, 0.0)}


@pytest.mark.parametrize(
    'content',
    [
        *('', '[]', 'hello', '3', '[1, 2]', '[[1, two]]', '{a: [1, 2]}', '[[1, .nan]]', '[['),
        *('[[yes, no, on]]', '{1: [1, 2], 1: [3, 4]}', '{1: [1, 2], tb3_1: [3, 4]}', '[' * 5000),
    ],
)
def test_malformed_poses_files_are_refused_in_one_line(tmp_path, content):
    path = tmp_path / 'poses.yaml'
    path.write_text(content)

    with pytest.raises(SetcmasError, match=r'poses\.yaml') as caught:
        given_poses(1, path)
    assert '\n' not in str(caught.value)


def test_single_poses_go_before_the_file(tmp_path):
    path = tmp_path / 'poses.yaml'
    path.write_text('{1: [1, 1, 1], 2: [2, 2, 2], 7: [7, 7, 7]}')

    assert given_poses(3, path, ['2:9,9,9']) == {1: (1.0, 1.0, 1.0), 2: (9.0, 9.0, 9.0)}


@pytest.mark.parametrize(
    ('file', 'given', 'message'),
    [
        ('none.yaml', [], r'none\.yaml.*No such file'),
        (None, ['4:0,0,0'], 'robots 1 to 3'),
        (None, ['1:0,0,0', '1:1,1,1'], 'robot 1 already has a pose'),
        ('short.yaml', [], '2 poses for 3 robots'),
    ],
)
def test_poses_that_do_not_fit_the_fleet_are_refused(tmp_path, file, given, message):
    (tmp_path / 'short.yaml').write_text('[[1, 1, 1], [2, 2, 2]]')

    assert list(given_poses(1, tmp_path / 'short.yaml')) == [1]
    with pytest.raises(SetcmasError, match=message):
        given_poses(3, file and tmp_path / file, given)


def distances(poses):
    x, y, _ = poses
    apart = np.hypot(x[:, None] - x, y[:, None] - y)
    return apart[~np.eye(len(x), dtype=bool)]


def test_poses_fill_the_box_and_keep_their_distance():
    places = RandomPoses.of('box=6x4,distance=0.5')
    drawn = [places.draw(8, seed) for seed in range(200)]
    x, y, theta = np.concatenate(drawn, axis=1)

    assert min(distances(poses).min() for poses in drawn) >= 0.5
    for values, side in ((x, 6.0), (y, 4.0), (theta, 2 * np.pi)):
        counts, _ = np.histogram(values, bins=8, range=(-side / 2, side / 2))
        assert counts.sum() == 1600
        assert (np.abs(counts - 200) < 5 * np.sqrt(200)).all()


def test_a_seed_gives_the_same_poses_and_another_one_others():
    first, again, other = (RandomPoses().draw(8, seed) for seed in (3, 3, 4))

    np.testing.assert_array_equal(first, again)
    assert not np.isin(other, first).any()


@pytest.mark.parametrize('nb_robots', [1, 8, 300])
def test_by_default_there_is_room_for_any_fleet(nb_robots):
    poses = RandomPoses().draw(nb_robots, 0)

    assert (distances(poses) >= 1.0).all()
    assert np.abs(poses[:2]).max() <= max(5.0, np.sqrt(nb_robots))


def test_a_full_box_has_a_shorter_distance_unless_one_is_asked_for():
    assert distances(RandomPoses.of('box=02x2.0').draw(8, 0)).min() >= np.sqrt(4 / 32)
    with pytest.raises(
        SetcmasError, match=r'8 robots .* 2x2 m at least 1 m apart; .* or distance=0\.35$'
    ):
        RandomPoses.of('box=2x2,distance=1').draw(8, 0)


def test_given_poses_stay_and_the_others_keep_away_from_them():
    poses = RandomPoses.of('box=2x2,distance=0.9').draw(3, 0, {2: (0.0, 0.0, 1.0)})

    assert poses[:, 1].tolist() == [0.0, 0.0, 1.0]
    assert distances(poses).min() >= 0.9


@pytest.mark.parametrize(
    'text',
    [
        *('', ',', 'box=4', 'box=4x3,', 'box=-4x3', 'box=0x3', 'distance=', 'distance=0', '4x3'),
        *('box=4x3;distance=1', 'box=4x3distance=1', ',distance=1'),
    ],
)
def test_other_texts_are_refused(text):
    with pytest.raises(SetcmasError, match=r"must be auto, or box=WIDTHxHEIGHT .* 'box=4x3,dist"):
        RandomPoses.of(text)
