from setcmas_tools.player.play_clock import PlayClock


def test_time_passes_at_the_rate():
    clock = PlayClock(10.0, at=5.0, now=100.0)

    assert clock.at(100.5) == 10.0
    assert clock.wait_s(15.0, 100.5) == 0.5
    assert clock.wait_s(1.0, 100.5) == 0.0


def test_a_pause_takes_no_time_and_a_step_leaves_it_paused():
    clock = PlayClock(2.0, at=0.0, now=0.0)

    clock.toggle(1.0)
    assert clock.at(50.0) == 2.0
    clock.move_to(2.5, 50.0)
    assert (clock.paused, clock.at(60.0)) == (True, 2.5)
    clock.toggle(60.0)
    assert clock.at(61.0) == 4.5
