"""The process of the controllers of a fleet: for each robot a controller and si_to_uni.

Start it with `ros2 run setcmas_ctrl controller --algo consensus`; without --algo, that is the
controller of one robot alone (`single_node.py`).
"""

from __future__ import annotations

import argparse
from dataclasses import replace

from setcmas_ctrl.communication.communication_settings import CommunicationOptions
from setcmas_ctrl.controllers.control_loop import run_controllers
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.laws.control_options import ControllerOptions, LawOptions
from setcmas_ctrl.laws.script_output import named_output
from setcmas_ctrl.laws.script_seeds import seeded_generators
from setcmas_simu.fleet import topics
from setcmas_simu.ros.parameters import NodeParameters, declare_fixed
from setcmas_simu.ros.process import FleetNode, RosProcess, end_process, node_main

PARAMETERS = {name: name for name in ('vnom', 'komega', 'rate')}
"""The options that are parameters of the node of the process, by parameter name."""


def main(argv: list[str] | None = None) -> int:
    """Control robots until a signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog='controllers', description=__doc__)
    LawOptions.add_to(parser)
    ControllerOptions.add_to(parser)
    CommunicationOptions.add_to(parser)
    FilterOptions.add_to(parser)
    return node_main(parser, _control, argv)


def _control(process: RosProcess, args: argparse.Namespace) -> int:
    with seeded_generators(), named_output():
        node = FleetNode(topics.CONTROLLERS, follows_clock=True, enable_rosout=True)
        parameters = NodeParameters(node, LawOptions.of(args), PARAMETERS)
        parameters.options = law_of_parameters(node, parameters.options)
        return run_controllers(
            process,
            node,
            parameters,
            CommunicationOptions.of(args),
            FilterOptions.of(args),
            fleet_of_parameters(node, ControllerOptions.of(args)),
        )


def law_of_parameters(node: FleetNode, law: LawOptions) -> LawOptions:
    """Declare parameters that say which law it is; return it, or raise SetcmasError."""
    algo = declare_fixed(node, topics.LAW, str(law.algo), 'the control law')
    exercise = declare_fixed(node, 'exercise', law.exercise, 'whether it is the exercise version')
    return replace(law, algo=algo, exercise=exercise)


def fleet_of_parameters(node: FleetNode, options: ControllerOptions) -> ControllerOptions:
    """Declare a parameter with the size of the fleet; return the options, or raise SetcmasError.

    Its value 0 stands for the size that is announced.
    """
    size = declare_fixed(node, 'nb_robots', options.nb_robots or 0, 'robots; 0: as announced')
    return replace(options, nb_robots=size or None)


def run_process() -> None:
    """Run `main` and end the process."""
    end_process(main())


if __name__ == '__main__':
    run_process()
