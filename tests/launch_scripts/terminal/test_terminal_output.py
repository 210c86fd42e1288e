import io

from launch_scripts.terminal.terminal_output import LineBuffer


def fed(*chunks, prefix=''):
    buffer = LineBuffer(prefix, io.StringIO())
    return [line for chunk in chunks for line in buffer.feed(chunk)]


def test_lines_come_out_whole_however_they_arrive():
    assert fed(b'on', b'e\ntw', b'o\nthree') == ['one', 'two']
    assert fed(b'one\ntwo', b'') == ['one', 'two']


def test_every_line_has_its_prefix():
    assert fed(b'one\n\ntwo\r\n', prefix='[simu] ') == ['[simu] one', '[simu] ', '[simu] two']


def test_severities_of_the_logger_become_words():
    lines = fed(b'INFO|hello\nWARN|take care\nERROR|no\nother|thing\n')

    assert lines == ['hello', 'warning: take care', 'error: no', 'other|thing']


def test_bytes_that_are_no_text_and_endless_lines_do_no_harm():
    assert fed(b'\xff\xfe\n') == ['\ufffd\ufffd']
    assert sum(map(len, fed(b'x' * 50_000))) == 50_000
