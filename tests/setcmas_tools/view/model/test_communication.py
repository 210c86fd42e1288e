import numpy as np

from setcmas_tools.view.model.communication import FLASH_S, Flashes, links, matrix


def test_links_both_ways_and_one_way():
    weights = np.array([[9, 1, 0], [0.5, 0, 0], [1, 0, 0]], float)  # robot 3 hears robot 1

    both, one_way = links(weights)

    assert both.tolist() == [[1, 2]]
    assert one_way.tolist() == [[1, 3]]


def test_a_message_that_does_not_fit_is_refused():
    assert matrix([2, 2], [0, 1, 1, 0]).tolist() == [[0, 1], [1, 0]]
    assert matrix([2, 3], [0] * 6) is None
    assert matrix([2, 2], [0] * 3) is None
    assert matrix([], []) is None


def test_a_flash_fades():
    flashes = Flashes()
    flashes.trigger(2, 10.0)

    assert flashes.strength([1, 2], 10.0).tolist() == [0.0, 1.0]
    assert 0.0 < flashes.strength([2], 10.0 + FLASH_S / 2)[0] < 1.0
    assert flashes.strength([2], 10.0 + FLASH_S)[0] == 0.0
    assert flashes.strength([], 10.0).shape == (0,)
