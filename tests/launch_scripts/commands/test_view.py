import pytest
from processes import refuses


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (('run/none',), 'there is no'),
        (('run', 'run', 'run'), '3 runs given; name one or two'),
        (('--port', '0'), '--port is 0; it must be a whole number from 1 to'),
    ],
)
def test_mistakes_are_reported_in_one_line(tmp_path, arguments, message):
    refuses('view', *arguments, message=message, cwd=tmp_path)
