import pytest

pytest.importorskip('rclpy')

from setcmas_simu.ros.messages import seconds_of
from setcmas_simu.ros.process import RosProcess
from setcmas_simu.ros.step_loop import ScaledClock, StepTime, run_steps


class Clock:
    """A clock that goes on only when it is waited for, or set."""

    def __init__(self) -> None:
        self.t = 100.0

    def now(self) -> float:
        return self.t

    def stamp(self) -> None:
        pass

    def wait_until(self, t: float, _: RosProcess) -> None:
        self.t = max(self.t, t)


class Steps:
    """Notes its steps, which may take their time; asks to stop after the last."""

    def __init__(self, clock: Clock, durations: list[float]) -> None:
        self.stopping = False
        self.times: list[float] = []
        self._clock = clock
        self._durations = iter(durations)

    def step(self, now: float) -> None:
        self.times.append(round(now - 100.0, 6))
        duration = next(self._durations, None)
        self.stopping = duration is None
        self._clock.t += duration or 0.0


@pytest.mark.parametrize(
    ('durations', 'times'),
    [
        ([0.0, 0.0, 0.19], [0.0, 0.2, 0.4, 0.6]),
        ([0.25, 0.0, 0.0], [0.0, 0.25, 0.4, 0.6]),  # late by less than a period
        ([0.9, 0.0, 0.0], [0.0, 0.9, 1.0, 1.2]),  # those of 0.2, 0.4 and 0.6 are left out
        ([0.25, 0.25, 0.0], [0.0, 0.25, 0.5, 0.6]),
    ],
)
def test_steps_keep_their_grid_and_are_not_made_up_for(durations, times):
    clock = Clock()
    steps = Steps(clock, durations)

    run_steps(steps, StepTime(0.2, clock), steps.step)
    assert steps.times == pytest.approx(times)


def test_the_period_may_change_on_the_way():
    clock = Clock()
    steps, time = Steps(clock, [0.0] * 3), StepTime(0.2, clock)

    def step(now):
        steps.step(now)
        time.period = 0.5

    run_steps(steps, time, step)
    assert steps.times == pytest.approx([0.0, 0.5, 1.0, 1.5])


def test_between_steps_it_polls_and_right_before_the_next_one_too():
    clock = Clock()
    steps, time = Steps(clock, [0.005]), StepTime(0.05, clock)
    time.is_polled = True
    polls = []

    run_steps(steps, time, steps.step, lambda: polls.append(round(clock.t - 100.0, 6)))
    assert polls == pytest.approx([0.01, 0.02, 0.03, 0.04])


def test_a_scaled_clock_is_that_of_stamps_too():
    clock = ScaledClock(5.0, begin=0.0)
    before, stamp, after = clock.now(), seconds_of(clock.stamp()), clock.now()

    assert before - 1e-9 <= stamp <= after + 1e-9
    assert before > 5e9 / 2  # five times the seconds since 1970, not those of the system
