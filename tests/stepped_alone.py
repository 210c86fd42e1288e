"""A node by itself in the process of its test: stepped by hand, by a clock that is set."""

from setcmas_simu.robot_node import StepTime
from setcmas_simu.ros.clocks import SteadyClock


class SetClock(SteadyClock):
    """A clock that is set."""

    t = 0.0

    def now(self) -> float:
        return self.t


class SteppedAlone:
    """Steps nodes, which share the time of their steps."""

    def __init__(self, period: float = 0.125) -> None:
        """Begin at 0; multiples of the period in s should be exact in binary."""
        self.clock = SetClock()
        self.time = StepTime(period, self.clock)
        self.nodes = []

    def arguments(self, peer, *given: str) -> dict:
        """Return arguments for a node, such as `-r __ns:=/tb3_3`, in a peer's process."""
        return {'time': self.time, 'context': peer.context, 'cli_args': ['--ros-args', *given]}

    def step(self, times: int = 1) -> None:
        """Let the time go on by periods, and step the nodes at each."""
        for _ in range(times):
            self.clock.t += self.time.period
            self.time.begin_step(self.clock.t)
            for node in self.nodes:
                node.step()
