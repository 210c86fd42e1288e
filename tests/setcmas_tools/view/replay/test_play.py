from setcmas_tools.view.replay.play import SPEEDS, Play


def test_it_plays_from_where_it_stands_to_the_end_and_then_again():
    play = Play(0.0, 10.0, 4.0, 100.0)
    assert (play.paused, play.at(105.0)) == (True, 4.0)

    play.toggle(105.0)
    assert (play.paused, play.at(107.5)) == (False, 6.5)
    assert (play.at(120.0), play.paused) == (10.0, True)
    play.toggle(130.0)
    assert play.at(131.0) == 1.0


def test_steps_are_tenths_of_a_second_and_stand():
    play = Play(0.0, 1.0, 0.53, 0.0)
    play.toggle(0.0)
    seen = []
    for number in (1, 1, -1, -1, -1):
        play.step(number, 0.0)
        seen.append(play.at(9.0))

    assert seen == [0.6, 0.7, 0.6, 0.5, 0.4]
    assert play.paused


def test_times_stay_inside_the_run():
    play = Play(0.0, 10.0, 99.0, 0.0)
    assert play.at(0.0) == 10.0
    play.seek(-3.0, 0.0)
    play.step(-1, 0.0)
    assert play.at(0.0) == 0.0


def test_a_change_of_speed_makes_no_jump():
    play = Play(0.0, 100.0, 10.0, 0.0)
    play.toggle(0.0)
    play.faster(1, 5.0)
    assert (play.at(5.0), play.at(6.0)) == (15.0, 17.0)
    for _ in SPEEDS:
        play.faster(-1, 6.0)
    assert play.speed == SPEEDS[0]
