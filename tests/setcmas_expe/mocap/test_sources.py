import pytest

from setcmas_expe.mocap.sources import (
    MOCAP_SOURCES,
    STANDARD,
    MocapSource,
    check_topic,
    checked_source,
)
from setcmas_simu.errors import SetcmasError
from setcmas_simu.plugins import InvalidPluginError

FOR_ALL = ('motion_capture_tracking', 'mocap4r2', 'tf')


@pytest.mark.parametrize('name', MOCAP_SOURCES.plugins())
def test_sources_make_sense(name):
    source = MOCAP_SOURCES.get(name)

    assert source.per_body == (name not in FOR_ALL)
    assert source.topic_of('Red').count('Red') == source.topic.count('{name}')
    if source.per_body:
        assert (source.message_type, source.read) in STANDARD.values()
        assert source.may_name('tb3_1')
        assert not source.may_name('3')
    else:
        assert source.may_name('Red.Red')
        assert not source.may_name('')


OF_A_BODY = r'must be the full name of a topic with \{name\}'
NO_TOPICS = ('', 'a/{name}', '/a', '/{name}/', '/a//{name}', '/a b/{name}', '/a-b/{name}')


@pytest.mark.parametrize(
    ('per_body', 'topic', 'reason'),
    [(True, topic, OF_A_BODY) for topic in NO_TOPICS]
    + [(False, topic, 'of all bodies') for topic in ('', 'poses', '/{name}', '/')],
)
def test_topics_that_are_none_are_refused(per_body, topic, reason):
    with pytest.raises(SetcmasError, match=reason):
        check_topic(topic, per_body)


@pytest.mark.parametrize(
    ('thing', 'reason'),
    [
        (1, 'it is a int; it must be a MocapSource'),
        (MocapSource('poses', 'a/msg/B', list), "topic 'poses' must be"),
        (MocapSource('/poses', 'B', list), "type 'B' must be like"),
    ],
)
def test_what_is_no_source_does_not_fit(thing, reason):
    with pytest.raises(InvalidPluginError, match=reason):
        checked_source(thing)
