"""Monitor of a fleet beside the steps of its nodes: lost robots, the pause, the time of others."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node
from std_msgs.msg import Bool

from setcmas_ctrl.controllers.fleet_time import FleetTime, FleetTimeTopic
from setcmas_ctrl.controllers.graph_watch import GraphWatch
from setcmas_ctrl.fleet_poses import POSE_TIMEOUT_S, FleetPoses
from setcmas_ctrl.laws.control_options import ControllerOptions
from setcmas_ctrl.pause_watch import PauseWatch
from setcmas_ctrl.si_to_uni_node import SiToUni
from setcmas_simu.fleet import topics
from setcmas_simu.reports import Launcher, Paused
from setcmas_simu.robot_node import StepTime
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.polling import PolledTopic


class FleetMonitor:
    """Watches what decides whether, and at which t, the robots of a process are controlled.

    Attributes:
        graph: Finds robots that do not listen, and other controllers.
        lost: Robots whose odometry is too old.
        is_paused: Whether the robots are paused in this step.
        run_time: The time t of the run.
        time_topic: Shares t with processes that control others; None if this one controls all.
        urgent: Topics that are to be taken at once.
    """

    def __init__(
        self,
        node: FleetNode,
        options: ControllerOptions,
        robots: Sequence[int],
        poses: FleetPoses,
        drivers: Sequence[SiToUni],
        launcher: Launcher,
        time: StepTime,
    ) -> None:
        """Watch some robots of the fleet in `poses`; `drivers` command them."""
        self.graph, self._time = GraphWatch(node, poses, drivers), time
        self._robots, self._poses, self._warn = robots, poses, node.get_logger().warning
        self.lost: set[int] = set()
        self.is_paused = False
        self.urgent: list[PolledTopic] = []
        if options.experiment:
            self._pause: PauseWatch | FleetPause = PauseWatch(node, options.pause_timeout)
        else:
            self._pause = FleetPause(node, drivers, launcher)
            self.urgent += self._pause.topics
        self.run_time, self.time_topic = FleetTime(), None
        if len(robots) < poses.poses.shape[1]:  # other processes may control the others
            self.time_topic = FleetTimeTopic(node, [*robots], self.run_time, time.clock)
            self.urgent.append(self.time_topic.topic)
        self.note_step()

    def begin_step(self) -> None:
        """Set t of a step, and find out whether the robots are paused."""
        # A step cannot receive odometry while it runs.
        self._find_lost(POSE_TIMEOUT_S + self._time.now - self._stepped)
        self.is_paused = self._pause.is_on
        self._time.t = self.run_time.step(self._time.now, self.is_paused)

    def _find_lost(self, timeout_s: float) -> None:
        """Report robots whose odometry becomes older than a time in s, and when it returns."""
        for robot in self._robots:
            age = self._poses.age(robot)
            if age > timeout_s and robot not in self.lost:
                self.lost.add(robot)
                fault = self._poses.fault(robot)
                missing = f'no valid pose ({fault})' if fault else 'no pose'
                topic = self._poses.topic_of(robot)
                self._warn(
                    f'robot {robot}: {missing} for {age:.1f} s on {topic}; it gets zero velocity'
                )
            elif age <= timeout_s and robot in self.lost:
                self.lost.remove(robot)
                self._warn(f'robot {robot}: its poses are back')

    def note_step(self) -> None:
        """Note that odometry counts from now on: a step cannot receive any while it runs."""
        self._stepped = self._time.clock.now()

    def end_step(self, has_laws: bool) -> None:
        """Tell other processes t, if it is that of laws, and look at the graph."""
        if self.time_topic and has_laws:
            self.time_topic.publish()
        self._stepped = self._time.now
        self.graph.check()

    @property
    def shares_t(self) -> bool:
        """Whether other processes use the same t."""
        return self.run_time.is_shared(self._time.clock.now())


class FleetPause:
    """Pauses and resumes simulated robots, and reports it to the launcher.

    In experiments controllers follow the pause node (`setcmas_ctrl/pause_watch.py`).

    Attributes:
        topics: Its topics, to be taken often.
    """

    def __init__(self, node: Node, drivers: Sequence[SiToUni], launcher: Launcher) -> None:
        """Subscribe through a node."""
        self._drivers = drivers
        self._launcher = launcher
        self._stopped = self._requested = False
        stop = topics.EMERGENCY_STOP
        self.topics = [
            PolledTopic(node, Bool, topics.FLEET_PAUSE, self._on_pause, qos.EVENT),
            *(PolledTopic(node, Bool, stop, self._on_stop, one) for one in qos.FROM_ANYBODY),
        ]

    @property
    def is_on(self) -> bool:
        """Whether all robots are paused."""
        if not self._drivers:  # controllers whose robots other processes drive
            return self._requested
        return all(driver.paused for driver in self._drivers)

    def _on_stop(self, message: Bool) -> None:
        if message.data and not self._stopped:
            self._pause(True, topics.EMERGENCY_STOP)
            print('stopped by /emergency_stop: restart this process to continue', flush=True)
            self._stopped = True
            for driver in self._drivers:
                driver.stopped = True

    def _on_pause(self, message: Bool) -> None:
        self._pause(message.data, '/pause')

    def _pause(self, paused: bool, by: str) -> None:
        if self._stopped:
            return
        if self._requested != paused or any(one.paused != paused for one in self._drivers):
            print(f'{"paused" if paused else "started"} by {by}', flush=True)
            self._launcher.report(Paused(paused))
        self._requested = paused
        for driver in self._drivers:
            driver.pause(paused)
