import pytest

pytest.importorskip('rclpy')

from setcmas_simu.ros.messages import seconds_of
from setcmas_simu.ros.process import RosProcess
from setcmas_simu.ros.step_loop import ScaledClock, StepLoop


class Clock:
    """A clock that goes on only when it is waited for, or set."""

    def __init__(self) -> None:
        self.t = 100.0

    def now(self) -> float:
        return self.t

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

    StepLoop(steps, 0.2, steps.step, clock).run()
    assert steps.times == pytest.approx(times)


def test_the_period_may_change_on_the_way():
    clock = Clock()
    steps = Steps(clock, [0.0] * 3)

    def step(now):
        steps.step(now)
        loop.period = 0.5

    loop = StepLoop(steps, 0.2, step, clock)
    loop.run()
    assert steps.times == pytest.approx([0.0, 0.5, 1.0, 1.5])


def test_between_steps_it_polls_and_right_before_the_next_one_too():
    clock = Clock()
    steps = Steps(clock, [0.005])
    polls = []
    loop = StepLoop(steps, 0.05, steps.step, clock)
    loop.poll = lambda: polls.append(round(clock.t - 100.0, 6))

    loop.run()
    assert polls == pytest.approx([0.01, 0.02, 0.03, 0.04])


def test_a_scaled_clock_is_that_of_stamps_too():
    clock = ScaledClock(5.0, begin=0.0)
    before, stamp, after = clock.now(), seconds_of(clock.stamp()), clock.now()

    assert before - 1e-9 <= stamp <= after + 1e-9
    assert before > 5e9 / 2  # five times the seconds since 1970, not those of the system
