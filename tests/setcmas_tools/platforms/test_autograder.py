import base64
import csv
import hashlib
import io
import zipfile

from setcmas_tools.platforms.autograder import own_wheel


def test_the_wheel_has_all_packages_with_their_data_and_a_right_record():
    name, content = own_wheel()
    wheel = zipfile.ZipFile(io.BytesIO(content))
    stem = name.removesuffix('-py3-none-any.whl')
    record = wheel.read(f'{stem}.dist-info/RECORD').decode()
    rows = {path: digest for path, digest, _ in csv.reader(record.splitlines())}

    assert rows.keys() == set(wheel.namelist())
    assert rows.keys() >= {
        'launch_scripts/cli.py',
        'setcmas_ctrl/exercises/consensus.yaml',
        'setcmas_tools/grade/templates/student.html',
        'setcmas_tools/platforms/templates/gradescope/setup.sh.in',
        'setcmas_tools/page/templates/base.css',
        'setcmas_tools/page/templates/player.js',
    }
    for path in (f'{stem}.dist-info/METADATA', 'setcmas_simu/errors.py'):
        digest = base64.urlsafe_b64encode(hashlib.sha256(wheel.read(path)).digest())
        assert rows[path] == f'sha256={digest.decode().rstrip("=")}'
    points = wheel.read(f'{stem}.dist-info/entry_points.txt').decode()
    assert 'gradescope = setcmas_tools.platforms.gradescope:GRADESCOPE' in points
    assert own_wheel() == (name, content)
