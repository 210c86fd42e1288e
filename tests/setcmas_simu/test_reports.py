import pytest

from setcmas_simu.reports import (
    Ended,
    Failed,
    LineDecoder,
    Mistake,
    Paused,
    Ready,
    Recording,
    Report,
    Started,
    encode,
)
from setcmas_simu.script_calls import Function, ScriptCall, ScriptFailure

CALL = ScriptCall(2, 'loi é.py', Function.CONTROL)
FAILURE = ScriptFailure(1.2, 2, Function.CONTROL, 'loi é.py', 3, 'two\nlines', 1.6)
REPORTS = [
    Ready(),
    Mistake('two\nlines'),
    Started((1, 2), 'law'),
    Failed(CALL, 'line 3: ValueError'),
    Ended((CALL, ScriptCall(1, 'when.py', Function.CONDITION)), (FAILURE,)),
    Recording(12),
    Paused(True),
]


@pytest.mark.parametrize('size', [1, 7, 10_000])
def test_reports_arrive_as_they_were_sent_however_a_pipe_cuts_them(size):
    data = b''.join(map(encode, REPORTS))
    decoder = LineDecoder(Report)
    parts = [data[i : i + size] for i in range(0, len(data), size)]

    assert [report for part in parts for report in decoder.feed(part)] == REPORTS


@pytest.mark.parametrize(
    'noise',
    [b'hello\n', b'{"type": "Started"}\n', b'{"type": "Nothing"}\n', b'\xff\xfe\n', b'[1', b'\n'],
)
def test_what_is_no_report_is_left_out(noise):
    decoder = LineDecoder(Report)

    assert list(decoder.feed(noise + encode(Ready()))) == [Ready()]


def test_a_call_is_described_in_words():
    assert str(CALL) == 'control of loi é.py for tb3_2'
