"""Files that a stranger may send: damaged at random, with fixed seeds."""

import random
import struct

import yaml

VALUES = (
    7, -1, 0, 1e308, float('nan'), float('inf'), 10**30, True, None, '', 'x' * 3000, '../../etc',
    [], {}, [[]], {'a': {'b': []}}, ['1', None], '1:a,2:b', '2001-01-01', '=1+1', '<script>',
)  # fmt: skip
CELLS = ('', 'nan', 'inf', '-inf', '1e308', '-1e308', '1e9', '-1', '0', '1.5', '2000', '99999999',
         'abc', '"', '\x00', '１', '0x10', '1_000', 'all', 'x' * 3000)  # fmt: skip


def damaged_bytes(content, chance):
    """Flip bits, cut, or write a huge length."""
    content = bytearray(content)
    kind = chance.randrange(4)
    if kind == 0:
        del content[chance.randrange(len(content)) :]
    elif kind == 1:
        for _ in range(chance.choice([1, 3, 30])):
            content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    elif kind == 2:
        start = chance.randrange(len(content))
        content[start:start] = content[chance.randrange(len(content)) :][:200]
    else:
        for _ in range(chance.choice([1, 3])):
            place = chance.randrange(max(1, len(content) - 8))
            length = chance.choice([2**31 - 1, 2**32 - 1, 2**40, 2**63 - 1, 2**64 - 1, 10**6, 0])
            struct.pack_into('<Q', content, place, length)
    return bytes(content)


def damaged_table(text, chance):
    """Change cells, rows or bytes of a CSV file."""
    lines = text.splitlines()
    for _ in range(chance.choice([1, 1, 5])):
        number = chance.randrange(len(lines))
        cells = lines[number].split(',')
        kind = chance.randrange(6)
        if kind < 3:
            cells[chance.randrange(len(cells))] = chance.choice(CELLS)
            lines[number] = ','.join(cells)
        elif kind == 3:
            lines[number] = ''
        elif kind == 4:
            lines += [lines[number]] * chance.randrange(50)
        else:
            lines[number] = damaged_bytes((lines[number] + ' ').encode() * 9, chance).decode(
                'latin-1'
            )
    return '\n'.join(lines)


def damaged_yaml(text, chance):
    """Change a value at any depth, or the text."""
    kind = chance.randrange(5)
    if kind == 0:
        return damaged_bytes(text.encode(), chance)
    if kind == 1:
        lines = text.splitlines()
        lines.insert(
            chance.randrange(len(lines)),
            chance.choice(['a: &a [*a]', 'b: ' + '[' * 900, '- 1', 'c: !!python/name:os.system',
                           '? [1, 2] : 3', 'd: &d [1]\ne: [*d, *d]', '\t', 'f: !!binary x',
                           'g: ' + '9' * 9000, '<<: {h: 1}', '%YAML 9.9', '---']),
        )  # fmt: skip
        return '\n'.join(lines).encode()
    content = yaml.safe_load(text)
    for _ in range(chance.choice([1, 1, 3])):
        _change(content, chance)
    return yaml.safe_dump(content).encode()


def _change(content, chance):
    place = content
    while True:
        keys = list(place) if isinstance(place, dict) else range(len(place))
        if not keys:
            return
        key = chance.choice(list(keys))
        if isinstance(place[key], (dict, list)) and place[key] and chance.random() < 0.8:
            place = place[key]
        else:
            place[key] = chance.choice(VALUES)
            return


def chances(name, count):
    """Yield generators with fixed seeds."""
    return (random.Random(f'{name} {i}') for i in range(count))
