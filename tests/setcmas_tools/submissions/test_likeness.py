import re

from setcmas_ctrl.laws.script_loader import ALGORITHMS, EXERCISES
from setcmas_tools.submissions.likeness import fingerprint, likenesses

NAME = 'leader_follower_formation'
GIVEN = fingerprint([EXERCISES.file(NAME).read_bytes()])
SHIPPED = ALGORITHMS.file(NAME).read_text()
KNOWN = {'the built-in law': fingerprint([SHIPPED.encode()], GIVEN)}


def shares(**sources):
    prints = {name: fingerprint([source.encode()], GIVEN) for name, source in sources.items()}
    found = likenesses(prints, KNOWN)
    return {name: {one.submission: one.share for one in like} for name, like in found.items()}


def test_a_copy_is_found_whatever_its_names_layout_and_comments():
    renamed = re.sub(r'\b(place|leader|waypoint|p)\b', r'my_\1', SHIPPED)
    renamed = renamed.replace('    return', '    # mine\n\n    return').replace("'''", '"""')

    assert shares(ada=renamed, bob='def control(i, n, poses, t):\n    return 0, 0\n') == {
        'ada': {'the built-in law': 1.0},
        'bob': {},
    }


def test_the_exercise_itself_and_scripts_that_are_not_python_are_like_nothing():
    exercise = EXERCISES.file(NAME).read_text()

    found = shares(ada=exercise, bob=exercise, cid='def', eve='-' * 100_000 + '1')

    assert found == {'ada': {}, 'bob': {}, 'cid': {}, 'eve': {}}


def test_a_sum_that_is_nested_deeply_does_not_hide_a_copy():
    assert shares(ada=f'{SHIPPED}\nx = {"+".join("1" * 2000)}\n') == {
        'ada': {'the built-in law': 0.92}
    }


def test_two_copies_name_each_other():
    other = SHIPPED.replace('    return', '    t += 1\n    return', 1)

    found = shares(ada=other, bob=other)

    assert found['ada']['bob'] == found['bob']['ada'] == 1.0
    assert 0.8 <= found['ada']['the built-in law'] < 1.0
