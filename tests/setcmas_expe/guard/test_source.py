from setcmas_expe.guard.source import Source

BRIDGE, PAUSE, ROGUE = b'bridge', b'pause', b'rogue'


def test_the_bridge_is_followed_beside_the_pause_node_and_nobody_beside_a_rogue():
    source = Source()
    assert source.conflict({BRIDGE, PAUSE}, PAUSE, free=False) == ''
    assert source.pinned == BRIDGE
    assert source.conflict({BRIDGE, PAUSE, ROGUE}, PAUSE, free=True) == 'several nodes command it'
    assert source.conflict({BRIDGE, ROGUE}, None, free=True)


def test_nobody_takes_the_place_of_the_bridge_while_the_robot_may_move():
    source = Source()
    source.conflict({BRIDGE}, None, free=False)
    assert source.conflict({ROGUE}, None, free=True)
    assert source.pinned == BRIDGE

    assert source.conflict({ROGUE}, None, free=False) == ''
    assert source.pinned == ROGUE
    source.conflict(set(), None, free=False)
    assert source.pinned == b''
