import pytest

from launch_scripts.terminal.start_key import StartKey


def starts(batches, held=False):
    """Return when batches of keys, 0.1 s from each other, start robots."""
    key = StartKey(held)
    return [step for step, keys in enumerate(batches) if key.pressed(keys, step / 10)]


@pytest.mark.parametrize('key', ['s', 'S'])
def test_the_key_alone_starts(key):
    assert len(starts([key, *[''] * 20])) == 1


@pytest.mark.parametrize(
    'batches',
    [
        ['ls\n'],
        ['ss'],
        ['l', 's', '\n'],
        ['s', 'o', 'u'],
        ['hello ', 's'],
        ['\x1b[200~s\x1b[201~'],
        ['', 's', ' '],
    ],
)
def test_words_that_are_typed_or_pasted_do_not(batches):
    assert starts([*batches, *[''] * 20]) == []
    assert starts([*batches, *[''] * 20, 's', *[''] * 5]) != []


def test_a_key_that_is_to_be_held_is_told_each_time():
    assert starts(['s', '', 'ss', 's', '', 'l', 's'], held=True) == [0, 2, 3]
