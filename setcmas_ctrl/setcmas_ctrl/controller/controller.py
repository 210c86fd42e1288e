"""The controller process: poses of the fleet in, velocities of control scripts out.

Start it with `ros2 run setcmas_ctrl controller --algo consensus`.
"""

from __future__ import annotations

import argparse
import contextlib
from functools import partial

from setcmas_ctrl import network
from setcmas_ctrl.communication.communication_settings import CommunicationOptions
from setcmas_ctrl.control.control_options import (
    SCRIPT_FAILED,
    ControllerOptions,
    GainOptions,
    LawOptions,
)
from setcmas_ctrl.controller.controlled_fleet import ControlledFleet
from setcmas_ctrl.controller.lockstep_controller import LockstepLoop
from setcmas_ctrl.controller.script_outcomes import end_stuck_script
from setcmas_ctrl.controller.stepper import ControlStepper
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.scripts.output import named_output
from setcmas_ctrl.scripts.script_errors import StopCall
from setcmas_ctrl.scripts.script_seeds import seeded_generators
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.ros.parameters import ProcessParameters, declare_fixed, fixed_in_lockstep
from setcmas_simu.ros.process import FleetNode, RosProcess, end_process, node_main
from setcmas_simu.ros.step_loop import StepLoop

PARAMETERS = {name: name for name in ('vnom', 'komega', 'rate')}
"""The options that are parameters of the process's node, by parameter name."""


def _keep_rate(rate: float, gains: GainOptions) -> None:
    """Check that the rate of an experiment does not change.

    Raises:
        SetcmasError: It would change.
    """
    if gains.rate != rate:
        raise SetcmasError(
            f'rate is fixed at {rate:g} Hz during an experiment, because robots stop when '
            'commands are late; restart it with another --rate'
        )


def main(argv: list[str] | None = None) -> int:
    """Control robots until a signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog='controller', description=__doc__)
    LawOptions.add_to(parser)
    ControllerOptions.add_to(parser)
    CommunicationOptions.add_to(parser)
    FilterOptions.add_to(parser)
    return node_main(parser, _control, argv)


def _control(process: RosProcess, args: argparse.Namespace) -> int:
    with seeded_generators(), named_output():
        node = FleetNode(topics.CONTROLLERS, follows_clock=True, enable_rosout=True)
        parameters = ProcessParameters(node, LawOptions.of(args), PARAMETERS)
        declare_fixed(node, topics.LAW, str(parameters.options.algo), 'the control law')
        parameters.warn_of_unknown()
        if args.experiment:
            parameters.check = partial(_keep_rate, parameters.options.rate)
        try:
            fleet = ControlledFleet(
                process,
                node,
                parameters.options,
                CommunicationOptions.of(args),
                FilterOptions.of(args),
                ControllerOptions.of(args),
            )
        except StopCall:
            return 0
        stepper, loop = fleet.stepper, fleet.loop
        process.take_signals()  # scripts may have changed the handlers while loading
        end_stuck_script(process, stepper.watch)
        try:
            with contextlib.suppress(StopCall), network.exchanged_by(stepper.communication):
                stepper.get_ready(process, args.recorded, isinstance(loop, LockstepLoop))
                _heed(parameters, stepper, loop)
                loop.run()
        finally:
            _end(process, stepper, loop)
        stepper.outcomes.end()
        return SCRIPT_FAILED if stepper.outcomes.failed else 0


def _heed(
    parameters: ProcessParameters[LawOptions],
    stepper: ControlStepper,
    loop: StepLoop | LockstepLoop,
) -> None:
    """Allow changes of parameters while the laws run, except in lockstep."""
    if isinstance(loop, StepLoop):
        parameters.on_change = partial(_follow, stepper, loop)
        _follow(stepper, loop, parameters.options)  # they may have changed meanwhile
    else:
        parameters.check = fixed_in_lockstep


def _follow(stepper: ControlStepper, loop: StepLoop, gains: GainOptions) -> None:
    stepper.follow(gains)
    loop.period = 1.0 / gains.rate
    stepper.watch.slow.period = loop.wall_period


def _end(process: RosProcess, stepper: ControlStepper, loop: StepLoop | LockstepLoop) -> None:
    if process.can_talk:
        stepper.stop()
        if isinstance(loop, LockstepLoop):
            loop.leave()
    stepper.watch.close()


def run() -> None:
    """Run `main` and end the process."""
    end_process(main())


if __name__ == '__main__':
    run()
