"""The wheel of the installed setcmas."""

import base64
import csv
import hashlib

from setcmas_tools.page.own_wheel import own_wheel


def test_the_wheel_has_all_packages_with_their_data_and_a_right_record():
    name, files = own_wheel(('setcmas_expe/',))
    stem = name.removesuffix('-py3-none-any.whl')
    record = files[f'{stem}.dist-info/RECORD'].decode()
    rows = {path: digest for path, digest, _ in csv.reader(record.splitlines())}

    assert rows.keys() == files.keys()
    assert rows.keys() >= {
        'launch_scripts/cli.py',
        'setcmas_ctrl/exercises/consensus.yaml',
        'setcmas_tools/grade/templates/student.html',
        'setcmas_tools/page/templates/player.js',
    }
    assert not [path for path in rows if path.startswith('setcmas_expe/')]
    for path in (f'{stem}.dist-info/METADATA', 'setcmas_simu/errors.py'):
        digest = base64.urlsafe_b64encode(hashlib.sha256(files[path]).digest())
        assert rows[path] == f'sha256={digest.decode().rstrip("=")}'
    points = files[f'{stem}.dist-info/entry_points.txt'].decode()
    assert 'unicycle = setcmas_simu.robots.unicycle:UNICYCLE' in points
