import sys
import textwrap

from control_functions import load_control

from setcmas_ctrl.laws.script_output import limited_output, named_output


def law(tmp_path, body, robot=2, top=''):
    path = tmp_path / 'law.py'
    body = textwrap.indent(textwrap.dedent(body), '    ')
    path.write_text(f'{top}\ndef control(i, n, p, t):\n{body}\n    return 0, 0\n')
    return load_control(path, robot)


def test_what_a_script_prints_has_its_robots_name_before_every_line(tmp_path, capsys):
    with named_output():
        control = law(tmp_path, 'print("call", i)\nprint("a\\n\\nb")', top='print("loaded")')
        control(2, 2, None, 0.0)
        print('of other code')

    expected = 'tb3_2: loaded\ntb3_2: call 2\ntb3_2: a\ntb3_2: \ntb3_2: b\nof other code\n'
    assert capsys.readouterr().out == expected


def test_pieces_of_a_line_are_put_together_and_the_last_line_ends(tmp_path, capsys):
    body = """
    import sys
    sys.stdout.write(f'{t} ')
    print(i, end='', flush=True)
    sys.stderr.write('to stderr')
    if t:
        print(' end')
        print('rest', end='')
    """
    with named_output():
        first, second = (law(tmp_path, body, robot) for robot in (1, 2))
        for t in (0, 1):
            first(1, 2, None, t)
            second(2, 2, None, t)

    captured = capsys.readouterr()
    assert captured.out.splitlines() == [
        'tb3_1: 0 11 1 end',
        'tb3_2: 0 21 2 end',
        'tb3_1: rest',
        'tb3_2: rest',
    ]
    assert captured.err == 'tb3_1: to stderrto stderr\ntb3_2: to stderrto stderr\n'


def test_the_stream_is_as_before_afterwards_and_has_all_that_it_had_meanwhile(capsys):
    before = sys.stdout
    with named_output():
        assert sys.stdout.encoding == before.encoding
        assert sys.stdout.isatty() is False
        sys.stdout.writelines(['a', 'b\n'])
    assert sys.stdout is before
    assert capsys.readouterr().out == 'ab\n'


def test_names_come_once_and_a_script_closes_only_its_own_output(tmp_path, capsys):
    with named_output(), named_output():
        law(tmp_path, 'import sys\nsys.stdout.close()\nprint("x")')(2, 2, None, 0.0)
    print('y')

    assert capsys.readouterr().out == 'tb3_2: x\ny\n'


def test_of_many_lines_the_first_are_shown(capsys):
    with limited_output():
        for k in range(60):
            print(k, end=' ')
            print('a', 'b', sep='')

    lines = capsys.readouterr().out.splitlines()
    assert lines == [f'{k} ab' for k in range(50)] + ['... 10 more lines']
