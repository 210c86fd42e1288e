import pytest
from message_schemas import fits

from setcmas_simu.fleet.announcement import Announcement, decode, encode

FIRST = Announcement(8, (1, 2, 3, 4))
ANNOUNCED = [
    FIRST,
    Announcement(8, (5, 8), ('car', 'unicycle'), 'burger', 5.0, 1e9),
]


@pytest.mark.parametrize('announcement', ANNOUNCED)
def test_an_announcement_is_understood_and_fits_the_published_schema(announcement):
    assert decode(encode(announcement)) == announcement
    assert fits('fleet-1', encode(announcement))


def test_what_is_as_usual_is_not_said():
    assert encode(FIRST) == '{"nb_robots":8,"robots":[1,2,3,4]}'


def test_fields_that_a_later_version_adds_do_no_harm():
    assert decode(encode(FIRST).replace('{', '{"colour":"red",', 1)) == FIRST


STRANGE = [
    '',
    'hello',
    '{}',
    '{"nb_robots":3}',
    '[1]',
    '{"nb_robots":3,"robots":[0]}',
    '{"nb_robots":3,"robots":[1],"rtf":0}',
]


@pytest.mark.parametrize('text', STRANGE)
def test_other_texts_fit_neither_the_reader_nor_the_published_schema(text):
    with pytest.raises(ValueError, match=r'Expected|missing|malformed|truncated|Invalid'):
        decode(text)
    assert not fits('fleet-1', text)
