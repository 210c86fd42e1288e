"""Preparation of a controller process: the fleet, the laws and the time that its nodes need."""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass

from setcmas_ctrl import drawing
from setcmas_ctrl.communication.communication_options import CommunicationOptions
from setcmas_ctrl.communication.communication_settings import Communication, chosen_communication
from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.control.control_options import ControllerOptions, LawOptions
from setcmas_ctrl.control.law_scripts import LawScripts
from setcmas_ctrl.controller.markers import MarkerCanvas, TaskTopic
from setcmas_ctrl.controller.script_outcomes import end_stuck_script
from setcmas_ctrl.controller.script_reload import LawLoader
from setcmas_ctrl.driving.fleet_discovery import (
    wait_for_announcement,
    wait_for_fleet,
    wait_for_source,
)
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.scripts.call_watch import CallWatch
from setcmas_ctrl.scripts.script_errors import StopCall
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.announcement import Lockstep, SimulatedTime
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.process import FleetNode, RosProcess


@dataclass(frozen=True)
class Wanted:
    """What a controller process is asked for.

    Attributes:
        law: Which control law, and how robots follow it.
        options: Which robots, and the source of their poses.
        communication: Who hears whom.
        safety: What keeps robots apart.
        scripts: The scripts of the law.
    """

    law: LawOptions
    options: ControllerOptions
    communication: CommunicationOptions
    safety: FilterOptions
    scripts: LawScripts

    @classmethod
    def of(cls, args: argparse.Namespace, law: LawOptions) -> Wanted:
        """Return what a command line asks for; parameters may have changed its law.

        Raises:
            SetcmasError: A script is missing or has a mistake.
        """
        communication = CommunicationOptions.of(args).found(law.exercise)
        options, safety = ControllerOptions.of(args), FilterOptions.of(args)
        return cls(law, options, communication, safety, law.scripts())


@dataclass(frozen=True)
class Prepared:
    """What is known before a controller process makes its nodes.

    Attributes:
        process: The process.
        node: Its node, which speaks for it.
        wanted: What it is asked for.
        announced: The robots that are announced.
        nb_robots: Size of the fleet.
        robots: The robots of this process.
        loader: Loads the laws, and knows who watches their calls.
        laws: The law of each robot.
        communication: How the fleet communicates.
        time: The time that the robots follow; None is the system's.
    """

    process: RosProcess
    node: FleetNode
    wanted: Wanted
    announced: FleetListener
    nb_robots: int
    robots: list[int]
    loader: LawLoader
    laws: list[ControlLaw]
    communication: Communication
    time: SimulatedTime | None

    @property
    def in_lockstep(self) -> bool:
        """Whether the robots wait for their laws."""
        return isinstance(self.time, Lockstep)

    def warn(self, text: str) -> None:
        """Show a message to the user."""
        self.node.get_logger().warning(text)


def prepare(process: RosProcess, node: FleetNode, wanted: Wanted) -> Prepared:
    """Find the fleet, load the laws, and learn which time there is.

    Raises:
        SetcmasError: A script cannot be loaded, or options contradict each other.
        StopCall: The process was asked to stop meanwhile.
    """
    process.add(node)
    announced = FleetListener(node)
    nb_robots = _found_fleet(process, node, announced, wanted.options)
    robots = wanted.options.controlled(nb_robots)
    wanted.scripts.check(nb_robots)
    drawing.canvas = canvas = MarkerCanvas(node)
    loader = _loader(process, node, wanted, robots, nb_robots)
    laws = loader.load()
    communication = chosen_communication(nb_robots, wanted.communication, wanted.law.seed)
    time = None
    if not wanted.options.experiment:
        _go_on(wait_for_announcement(process, node, announced, nb_robots))
        time = announced.time
    if isinstance(time, Lockstep):
        _check_lockstep(wanted.options, communication, nb_robots)
        canvas.profile = qos.LOCKSTEP_STATE  # a recorder gets the first ones, too
    return Prepared(
        process, node, wanted, announced, nb_robots, robots, loader, laws, communication, time
    )


def _found_fleet(
    process: RosProcess, node: FleetNode, announced: FleetListener, options: ControllerOptions
) -> int:
    # Nothing is commanded to robots of another user's simulator.
    if options.simulator:
        _go_on(wait_for_source(process, node, announced, options.simulator))
    nb_robots = options.nb_robots or wait_for_fleet(process, node, announced)
    _go_on(nb_robots)
    return nb_robots


def _go_on(found: object) -> None:
    """End the process if nothing was found: then it was asked to stop."""
    if not found:
        raise StopCall


def _loader(
    process: RosProcess, node: FleetNode, wanted: Wanted, robots: list[int], nb_robots: int
) -> LawLoader:
    watch = CallWatch(math.inf, node.get_logger().warning, process.launcher)
    end_stuck_script(process, watch)
    task = TaskTopic(node, nb_robots)
    return LawLoader(wanted.scripts, wanted.law.seed, robots, nb_robots, watch, task)


def _check_lockstep(
    options: ControllerOptions, communication: Communication, nb_robots: int
) -> None:
    """Check that a controller can follow a simulator in lockstep.

    Raises:
        SetcmasError: It cannot.
    """
    if options.cmd_vel_type == 'twist':
        raise SetcmasError(
            'the simulator is in lockstep and needs commands with a stamp: '
            '--cmd-vel-type must be twist_stamped'
        )
    if communication.event_triggered and len(options.controlled(nb_robots)) < nb_robots:
        raise SetcmasError(
            'the simulator is in lockstep: event-triggered robots must all be controlled by one '
            'process; leave out --robots'
        )
