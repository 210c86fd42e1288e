import pytest
from processes import run_setcmas

OFFLINE = ('offline', '--algo', 'consensus', '--nb-robots', '2', '--duration', '1', '-o', 'out')


def test_what_a_terminal_leaves_behind_breaks_nothing_and_is_not_told(tmp_path):
    left_behind = {
        'PYTHONWARNINGS': 'error',
        'MPLBACKEND': 'module://matplotlib_inline.backend_inline',
        'HOME': '/proc',
    }
    result = run_setcmas(*OFFLINE, cwd=tmp_path, **left_behind)

    assert result.returncode == 0, result.stderr
    assert result.stderr == ''
    assert (tmp_path / 'out' / 'plots' / 'trajectories.png').is_file()


def test_warnings_that_are_errors_do_not_end_ros(domain):
    pytest.importorskip('rclpy')

    result = run_setcmas('record', '-o', '/', PYTHONWARNINGS='error')
    assert 'exists already' in result.stderr
    result = run_setcmas('fault', 'freeze', PYTHONWARNINGS='error')
    assert 'Warning' not in result.stderr


def test_another_middleware_than_the_wheels_is_told(domain, monkeypatch):
    pytest.importorskip('rclpy')
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)

    result = run_setcmas('simu', RMW_IMPLEMENTATION='rmw_cyclonedds_cpp')

    assert result.returncode == 2
    assert result.stderr.endswith('unset RMW_IMPLEMENTATION\n')
    assert result.stderr.count('\n') == 1


def test_any_file_name_makes_plots_in_silence(tmp_path):
    name = '共识 é a$b$c_$.py'
    (tmp_path / name).write_text('def control(i, n, p, t):\n    return 0.1, 0\n', encoding='utf-8')

    result = run_setcmas(*OFFLINE, '--algo', name, cwd=tmp_path)

    assert result.returncode == 0, result.stderr
    assert result.stderr == ''


def test_logging_of_a_script_shows_the_scripts_own_lines(tmp_path):
    (tmp_path / 'law.py').write_text(
        'import logging\nlogging.basicConfig(level=logging.DEBUG)\n'
        'def control(i, n, p, t):\n    logging.debug("mine")\n    return 0, 0\n'
    )

    result = run_setcmas(*OFFLINE, '--algo', 'law.py', cwd=tmp_path)

    assert result.returncode == 0, result.stderr
    assert {line.split(': ', 1)[1] for line in result.stderr.splitlines()} == {'DEBUG:root:mine'}
