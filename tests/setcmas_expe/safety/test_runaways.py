from setcmas_expe.safety.runaways import AFTER_S, Runaways


def test_a_robot_that_does_not_stop_is_noticed_once():
    runaways = Runaways()

    assert not runaways.update(2, False, 0.2, False, 1.0)  # it is commanded to move
    assert not runaways.update(2, True, 0.2, False, 0.9 * AFTER_S + 1.0)  # it needs its time
    assert runaways.update(2, True, -0.2, False, 1.1 * AFTER_S + 1.0)
    assert not runaways.update(2, True, 0.19, False, 1.2 * AFTER_S + 1.0)
    assert runaways.robots == {2: 0.19}

    runaways.update(2, False, 0.2, False, 8.0)
    assert runaways.robots == {}
    assert not runaways.update(2, True, 0.2, False, 8.5)


def test_a_robot_that_came_to_rest_is_carried():
    runaways = Runaways()
    assert not runaways.update(1, True, 0.3, False, 0.0)  # it was never commanded
    assert not runaways.update(1, True, 0.3, False, 5.0)
    runaways.update(1, False, 0.2, False, 6.0)
    runaways.update(1, True, 0.01, False, 6.5)

    assert not runaways.update(1, True, 0.3, False, 9.0)
    assert runaways.robots == {}


def test_a_robot_that_somebody_else_commands_is_not_carried():
    runaways = Runaways()
    assert not runaways.update(1, True, 0.0, True, 0.0)

    assert runaways.update(1, True, 0.2, True, 2 * AFTER_S)


def test_a_robot_that_came_to_rest_and_whose_wheels_turn_again_is_driven():
    runaways = Runaways()
    assert not runaways.update(1, True, 0.0, True, 0.0)
    assert not runaways.update(1, True, 0.0, True, 9.0)
    assert not runaways.update(1, True, 0.2, True, 9.1)

    assert runaways.update(1, True, 0.2, True, 9.1 + AFTER_S)
