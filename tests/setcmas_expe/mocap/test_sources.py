import pytest

from setcmas_expe.mocap.sources import MESSAGE_TYPES, PRESETS, check_template, topic_of
from setcmas_simu.errors import SetcmasError


@pytest.mark.parametrize('preset', PRESETS.values(), ids=list(PRESETS))
def test_presets_make_sense(preset):
    assert check_template(preset.topic) == preset.topic
    assert preset.message_type in MESSAGE_TYPES
    assert topic_of(preset.topic, 'Red').count('Red') == preset.topic.count('{name}')
    assert preset.lost_looks_like


@pytest.mark.parametrize(
    'template', ['', 'a/{name}', '/a', '/{name}/', '/a//{name}', '/a b/{name}']
)
def test_templates_that_are_no_topics_are_refused(template):
    with pytest.raises(SetcmasError, match='is not accepted'):
        check_template(template)
