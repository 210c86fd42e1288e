"""Whatever happens to a file, a bag is read as far as it goes, or refused in one line."""

import contextlib
import random

import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags.bag import open_bag
from setcmas_tools.bags.message_types import UndecodableError


def cut(content, chance):
    return content[: chance.randrange(len(content))]


def flip(content, chance):
    for _ in range(3):
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    return content


def blank(content, chance):
    start = chance.randrange(len(content))
    content[start : start + 512] = bytes(len(content[start : start + 512]))
    return content


def insert(content, chance):
    start = chance.randrange(len(content))
    content[start:start] = chance.randbytes(7)
    return content


@pytest.mark.parametrize('kind', ['mcap', 'sqlite3', 'ros1'])
@pytest.mark.parametrize('damage', [cut, flip, blank, insert])
def test_damaged_bag(tmp_path, write_bag, write_ros1_bag, points, kind, damage):
    if kind == 'ros1':
        whole = write_ros1_bag(tmp_path / 'whole.bag', points)
    else:
        folder = write_bag(tmp_path / 'whole', points, kind)
        (whole,) = (file for file in folder.iterdir() if file.suffix != '.yaml')
    content = whole.read_bytes()
    chance = random.Random(f'{kind} {damage.__name__}')
    path = tmp_path / f'damaged{whole.suffix}'
    for _ in range(60):
        path.write_bytes(damage(bytearray(content), chance))
        lines = read_all(path, len(points))
        assert not any('\n' in line or len(line) > len(str(path)) + 300 for line in lines)


def read_all(path, expected):
    count = 0
    try:
        with open_bag(path) as bag:
            for topic, _, data in bag.messages():
                count += 1
                with contextlib.suppress(UndecodableError):
                    topic.type.decode(data)
            assert count >= expected or bag.notices
            return bag.notices
    except SetcmasError as error:
        return [str(error)]
