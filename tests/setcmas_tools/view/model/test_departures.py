from setcmas_tools.view.model.departures import GRACE_S, Departures


def test_what_is_gone_counts_for_a_while():
    topics = Departures()

    assert not topics.look({'/a', '/b'}, 0.0)
    assert not topics.look({'/b'}, 1.0)
    assert not topics.look({'/b'}, 0.9 + GRACE_S)
    assert topics.look({'/b'}, 1.0 + GRACE_S) == {'/a'}
    assert not topics.look({'/a', '/b'}, 9.0)


def test_what_comes_back_is_another_ones():
    topics = Departures()
    topics.look({'/a'}, 0.0)
    topics.look({}, 1.0)

    assert topics.look({'/a'}, 1.5) == {'/a'}
    assert not topics.look({'/a'}, 9.0)
