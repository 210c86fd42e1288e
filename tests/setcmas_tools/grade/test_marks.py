from setcmas_tools.grade.marks import Failure


def test_lines_around_a_failure_are_counted_as_python_does_and_none_is_too_long():
    source = 'a\x0cb\r\nc\n' + 'd' * 1000 + '\ne\rf\ng'
    failure = Failure('it failed').at('law.py', 3, source)

    assert failure.first == 1
    assert failure.around == ('a\x0cb', 'c', 'd' * 200, 'e', 'f')
