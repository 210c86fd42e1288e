import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.pose_options import given_poses, load_poses, parse_pose_option


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

    assert load_poses(path) == {1: (1.0, 2.0, 3.0), 2: (4.0, 5.0, 0.0)}


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
        load_poses(path)
    assert '\n' not in str(caught.value)


def test_a_missing_poses_file_is_named(tmp_path):
    with pytest.raises(SetcmasError, match=r'none\.yaml.*No such file'):
        load_poses(tmp_path / 'none.yaml')


def test_single_poses_go_before_the_file(tmp_path):
    path = tmp_path / 'poses.yaml'
    path.write_text('{1: [1, 1, 1], 2: [2, 2, 2], 7: [7, 7, 7]}')

    assert given_poses(3, path, ['2:9,9,9']) == {1: (1.0, 1.0, 1.0), 2: (9.0, 9.0, 9.0)}


def test_a_pose_for_a_robot_outside_the_fleet_is_refused():
    with pytest.raises(SetcmasError, match='robots 1 to 3'):
        given_poses(3, None, ['4:0,0,0'])


def test_a_list_that_is_shorter_than_the_fleet_is_refused(tmp_path):
    path = tmp_path / 'poses.yaml'
    path.write_text('[[1, 1, 1], [2, 2, 2]]')

    with pytest.raises(SetcmasError, match=r'2 poses for 3 robots'):
        given_poses(3, path)
    assert list(given_poses(1, path)) == [1]


def test_a_pose_that_is_given_twice_is_refused():
    with pytest.raises(SetcmasError, match='robot 1 already has a pose'):
        given_poses(3, None, ['1:0,0,0', '1:1,1,1'])
