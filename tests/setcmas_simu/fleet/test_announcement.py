import pytest

from setcmas_simu.fleet.announcement import (
    Announcement,
    Kind,
    Source,
    decode,
    encode,
    own_source,
    robots_of,
)

FIRST = Announcement(8, (1, 2, 3, 4), Source(Kind.SIMULATOR, 'here', 12))
SECOND = Announcement(8, (5, 8), Source(Kind.LAB, 'there', 12))


@pytest.mark.parametrize('announcement', [FIRST, SECOND])
def test_an_announcement_is_understood(announcement):
    assert decode(encode(announcement)) == announcement


def test_fields_that_a_later_version_adds_do_no_harm():
    assert decode(encode(FIRST).replace('{', '{"colour":"red",', 1)) == FIRST


@pytest.mark.parametrize('text', ['', 'hello', '{}', '{"nb_robots":3}', '[1]'])
def test_other_texts_are_none(text):
    assert decode(text) is None


def test_robots_of_several_processes_are_one_fleet():
    assert robots_of([SECOND, FIRST]) == [1, 2, 3, 4, 5, 8]


def test_a_source_is_told_in_words():
    assert str(FIRST.source) == 'simulator (process 12 on here)'
    assert own_source(Kind.LAB) == own_source(Kind.LAB)
