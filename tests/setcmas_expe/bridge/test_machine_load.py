from setcmas_expe.bridge.machine_load import StallDetector


def test_regular_signs_of_life_are_no_hold_up():
    stalls = StallDetector(0.5, 100.0)

    assert [stalls.tick(100.0 + 0.4 * i) for i in range(1, 20)] == [0.0] * 19
    assert not stalls.recent(108.0)


def test_a_gap_is_reported_once_and_what_comes_in_after_it_is_not_trusted_for_a_while():
    stalls = StallDetector(0.5, 100.0)

    assert stalls.recent(103.0)  # before the first sign of life after it, too
    assert stalls.tick(103.0) == 3.0
    assert stalls.tick(103.1) == 0.0
    assert stalls.tick(103.5) == 0.0
    assert stalls.recent(103.9)
    assert stalls.tick(103.9) == 0.0
    assert not stalls.recent(104.1)
