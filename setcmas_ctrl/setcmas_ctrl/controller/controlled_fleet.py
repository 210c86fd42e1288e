"""Controlled fleet: finds the robots of a process, loads their laws, creates topics and loop."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from setcmas_ctrl import drawing
from setcmas_ctrl.communication.communication_settings import (
    CommunicationOptions,
    chosen_communication,
)
from setcmas_ctrl.communication.triggering_conditions import CTC
from setcmas_ctrl.control.commander import Commander
from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.control.control_options import ControllerOptions, LawOptions
from setcmas_ctrl.control.law_scripts import LawScripts
from setcmas_ctrl.controller.event_triggered_comm import EventTriggeredComm, broadcasters
from setcmas_ctrl.controller.graph_watch import GraphWatch
from setcmas_ctrl.controller.law_loader import LawLoader, ScriptReloader
from setcmas_ctrl.controller.lockstep_controller import LockstepLoop, LockstepOdometry
from setcmas_ctrl.controller.markers import MarkerCanvas, TaskTopic, publish_obstacles
from setcmas_ctrl.controller.network_links import FleetCommunication
from setcmas_ctrl.controller.script_outcomes import ScriptOutcomes, end_stuck_script
from setcmas_ctrl.controller.stepper import ControlStepper
from setcmas_ctrl.driving.driven_robot import Controller, DrivenModels, SiToUni
from setcmas_ctrl.driving.fleet_discovery import wait_for_fleet, wait_until
from setcmas_ctrl.driving.fleet_pause import FleetPause, PauseWatch
from setcmas_ctrl.driving.odometry import FleetOdometry, offered_profile
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.scripts.call_watch import CallWatch
from setcmas_ctrl.scripts.conversion_script import script_conversions
from setcmas_ctrl.scripts.script_errors import StopCall
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.announcement import Lockstep
from setcmas_simu.reports.script_calls import Function
from setcmas_simu.robots.arena import Arena, Obstacles
from setcmas_simu.robots.model import limits_named
from setcmas_simu.robots.models import model_names
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.process import SIMULATED_TIME, FleetNode, RosProcess
from setcmas_simu.ros.step_loop import ScaledClock, SteadyClock, StepLoop, TopicClock


class ControlledFleet:
    """The robots that one process controls, all or some of a fleet."""

    def __init__(
        self,
        process: RosProcess,
        node: FleetNode,
        law: LawOptions,
        communication: CommunicationOptions,
        safety: FilterOptions,
        options: ControllerOptions,
    ) -> None:
        """Find the fleet, load its laws, and create the topics of its robots.

        Raises:
            SetcmasError: A script does not load, or options contradict each other.
            StopCall: The process was asked to stop meanwhile.
        """
        self._process, self._node, self._warn = process, node, node.get_logger().warning
        self._law, self._safety, self._options = law, safety, options
        communication, scripts = communication.found(law.exercise), law.scripts()
        process.add(node)
        self._announced = FleetListener(node)
        self._nb_robots = options.nb_robots or self._find()
        self._robots = options.controlled(self._nb_robots)
        scripts.check(self._nb_robots)
        drawing.canvas = canvas = MarkerCanvas(node)
        self._loader = self._law_loader(scripts)
        laws = self._loader.load()
        self._communication = chosen_communication(self._nb_robots, communication, law.seed)
        self._lockstep = self._followed_lockstep()
        if self._in_lockstep:
            canvas.profile = qos.LOCKSTEP_STATE  # a recorder gets the first ones, too
        self._odometry = self._poses()
        self.stepper, graph = self._stepper(laws)
        senders = self._connect()
        if options.watch:
            ScriptReloader(
                node,
                self.stepper,
                laws,
                self._loader,
                self._communication,
                senders,
                options.pause_timeout,
            )
        self.loop = self._loop(senders, graph)

    def _find(self) -> int:
        """Wait for the fleet; return its size, which is the given one if there is one."""
        nb_robots = wait_for_fleet(
            self._process, self._node, self._announced, self._options.nb_robots
        )
        _go_on(nb_robots)
        return nb_robots

    def _law_loader(self, scripts: LawScripts) -> LawLoader:
        watch = CallWatch(self._warn, self._process.launcher)
        end_stuck_script(self._process, watch)
        task = TaskTopic(self._node, self._nb_robots)
        return LawLoader(scripts, self._law.seed, self._robots, self._nb_robots, watch, task)

    def _followed_lockstep(self) -> Lockstep | None:
        """Return the steps of the simulator; None if it is not in lockstep.

        Raises:
            SetcmasError: The laws cannot follow a simulator in lockstep.
        """
        if self._options.experiment:
            return None
        if self._options.nb_robots:  # laws load before there is a fleet
            self._find()
        lockstep = self._announced.lockstep
        if lockstep and self._options.cmd_vel_type == 'twist':
            raise SetcmasError(
                'the simulator is in lockstep and needs commands with a stamp: '
                '--cmd-vel-type must be twist_stamped'
            )
        is_part = len(self._robots) < self._nb_robots
        if lockstep and self._communication.event_triggered and is_part:
            raise SetcmasError(
                'the simulator is in lockstep: event-triggered robots must all be controlled by '
                'one process; leave out --robots'
            )
        return lockstep

    @property
    def _in_lockstep(self) -> bool:
        return self._lockstep is not None

    def _poses(self) -> FleetOdometry:
        profile = qos.STATE
        if not (self._options.experiment or self._announced.robots):  # robots of others
            profile = offered_profile(self._node, topics.odometry_topic(self._robots[0]))
        # With event-triggered broadcast the laws know the other robots only by what they send;
        # but the range of a radio depends on where robots are.
        kind = LockstepOdometry if self._in_lockstep else FleetOdometry
        return kind(
            self._node,
            self._nb_robots,
            topics.mocap_topic if self._options.experiment else topics.odometry_topic,
            None if self._communication.needs_all_poses else self._robots,
            profile,
        )

    def _stepper(self, laws: list[ControlLaw]) -> tuple[ControlStepper, GraphWatch]:
        controllers = [
            Controller(self._node, law, self._in_lockstep, self._safety.is_on) for law in laws
        ]
        self._show_surroundings()
        drivers = self._drivers()
        pause = self._pause(drivers)
        graph = GraphWatch(self._node, self._odometry, self._announced, drivers, self._warn)
        scripts = {law.robot: law.path for law in laws}
        condition = self._communication.condition_script or Path(CTC)
        conversion = Path(str(self._law.conversion()))
        outcomes = ScriptOutcomes(
            self._warn, self._loader.watch, self._process.launcher, scripts, condition, conversion
        )
        commander = self._commander(drivers, outcomes)
        robots = list(zip(controllers, drivers, strict=True))
        stepper = ControlStepper(
            self._node, self._odometry, robots, commander, outcomes, graph, pause
        )
        return stepper, graph

    def _show_surroundings(self) -> None:
        arena = None  # that of an experiment is the bridge's to show
        if self._safety.arena and not self._options.experiment:
            arena = Arena(*self._safety.arena)
        publish_obstacles(self._node, Obstacles.of(self._safety.obstacles or ''), arena)

    def _drivers(self) -> list[SiToUni]:
        options = self._options
        topic = topics.CMD_VEL_WANTED if options.experiment else topics.CMD_VEL
        drivers = [
            SiToUni(self._node, robot, options.cmd_vel_type, topic, self._in_lockstep)
            for robot in self._robots
        ]
        models = DrivenModels(drivers, self._warn)
        if options.model:
            models.use(model_names(options.model, self._nb_robots))
        else:
            models.follow(self._announced)
        return drivers

    def _commander(self, drivers: list[SiToUni], outcomes: ScriptOutcomes) -> Commander:
        scripts = script_conversions(
            self._law.conversion(),
            self._robots,
            outcomes.conversions,
            lambda: self.stepper.t,
            partial(self._loader.watch.call, function=Function.SI_TO_UNI),
        )
        commander = Commander(
            self._law, self._safety, self._robots, self._nb_robots, self._warn, scripts
        )
        commander.limits = self._options.limits or limits_named(self._announced.limits)
        commander.use([driver.model for driver in drivers])
        return commander

    def _pause(self, drivers: list[SiToUni]) -> PauseWatch | None:
        """Let the fleet be paused; return the monitor of an experiment's pause node."""
        if self._options.experiment:
            return PauseWatch(self._node, self._options.pause_timeout)
        FleetPause(self._node, drivers, self._process.launcher, self._in_lockstep)
        return None

    def _connect(self) -> list[EventTriggeredComm]:
        """Let the robots communicate; return those that send states when triggered."""
        stepper = self.stepper
        profile = qos.LOCKSTEP_STATE if self._in_lockstep else qos.LATCHED
        stepper.communication = FleetCommunication(
            self._node, self._odometry, self._communication, self._robots, profile
        )
        if not self._communication.event_triggered:
            return []
        senders = broadcasters(
            self._node,
            self._robots,
            self._communication,
            self._odometry,
            stepper.outcomes.conditions,
            lambda: stepper.t,
            stepper.watch,
            self._in_lockstep,
        )
        stepper.communication.broadcasters = {one.robot: one for one in senders}
        return senders

    def _loop(
        self, senders: list[EventTriggeredComm], graph: GraphWatch
    ) -> StepLoop | LockstepLoop:
        rate, stepper, process = self._law.rate, self.stepper, self._process
        if self._lockstep and isinstance(self._odometry, LockstepOdometry):
            return LockstepLoop(
                process, self._node, self._odometry, stepper, senders, graph, rate, self._lockstep
            )
        clock = SteadyClock()
        if self._announced.rtf != 1.0:
            clock = ScaledClock(self._announced.rtf, self._announced.begin)
        elif self._node.get_parameter(SIMULATED_TIME).value:
            clock = self._clock_of_another_simulator()
        stepper.clock = clock
        loop = StepLoop(process, 1.0 / rate, stepper.step, clock)

        def poll() -> None:
            loop.poll = stepper.take

        if stepper.links:  # it counts when a state comes
            poll()
        elif stepper.communication:
            stepper.communication.on_begin = poll
        return loop

    def _clock_of_another_simulator(self) -> TopicClock:
        clock = TopicClock(self._node)
        text = f'waiting for the time on {topics.CLOCK} ({SIMULATED_TIME}); is it published?'
        _go_on(wait_until(self._process, clock.has_begun, lambda: self._warn(text)))
        return clock


def _go_on(found: object) -> None:
    """End the process if nothing was found: then it was asked to stop."""
    if not found:
        raise StopCall
