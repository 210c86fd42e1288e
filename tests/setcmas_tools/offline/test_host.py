import pickle
import sys

import pytest

from setcmas_tools.grade.sandbox import sandbox
from setcmas_tools.grade.sandboxed_script import LOADED, SandboxedScript
from setcmas_tools.offline.kernel_confinement import obstacle

pytestmark = pytest.mark.skipif(bool(obstacle()), reason=obstacle())

HIDING = ('gc', 'msgspec', 'numpy', 'pyseccomp', 'resource', 'socket', 'json', 'ast')
STARTED = ('sitecustomize', 'usercustomize')
USER = '.local/lib/python{}.{}/site-packages'.format(*sys.version_info)
LAW = b'import helper\ndef control(i, n, poses, t):\n    return helper.V, 0\n'


def forged(outside):
    """Return the files of a submission that tells outside where it may which of them ran."""
    told = f'open({str(outside)!r} + "/" + __name__, "w").close()\n'.encode()
    path_file = f'import sys; open({str(outside / "pth")!r}, "w").close()\n'.encode()
    names = [f'{folder}{name}.py' for name in HIDING + STARTED for folder in ('', f'{USER}/')]
    return {**dict.fromkeys(names, told), f'{USER}/all.pth': path_file}


def test_nothing_of_a_submission_runs_before_it_is_confined(tmp_path):
    outside = tmp_path / 'outside'
    outside.mkdir()
    files = {'law.py': LAW, 'helper.py': b'V = 0.25\n', **forged(outside)}
    with sandbox(tmp_path, confined=True) as host:
        for _ in range(2):
            child = host.begin(pickle.dumps(SandboxedScript('law.py', False, 1, 1, 1, {})), files)
            assert child.receive(10, 'late', ()) == LOADED[False]
            host.process.kill()  # what is started next finds the files of this one
            host.process.wait()
            child.end()

    assert list(outside.iterdir()) == []
