"""Parameters of nodes: options that can be set while it runs, and fixed values."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, Generic

from rcl_interfaces.msg import (
    FloatingPointRange,
    ParameterDescriptor,
    ParameterType,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from setcmas_simu.errors import SetcmasError, did_you_mean
from setcmas_simu.option_groups import Group, Option
from setcmas_simu.option_kinds import Number
from setcmas_simu.ros.fleet_node import FleetNode


class NodeParameters(Generic[Group]):
    """Keeps a group of options equal to the parameters of a node.

    Attributes:
        options: The options with the current values of the parameters; others after a change.
    """

    def __init__(
        self,
        node: FleetNode,
        options: Group,
        names: Sequence[str] | Mapping[str, str],
        fixed: Container[str] = (),
        check: Callable[[Group], object] = bool,
    ) -> None:
        """Declare parameters: options by their names, or the option of each parameter.

        `--ros-args` overrides the options; those in `fixed` cannot be set later, and `check`
        raises SetcmasError to refuse others. Raises SetcmasError for an invalid value.
        """
        self._node = node
        self._check = check
        names = names if isinstance(names, Mapping) else {name: name for name in names}
        self._names = names
        self._is_quiet, self._followed = False, options
        known: dict[str, Option] = {one.name: one.metadata['option'] for one in fields(options)}
        self._options = {parameter: known[name] for parameter, name in names.items()}
        for parameter, name in names.items():
            anything = ParameterDescriptor(dynamic_typing=True)
            node.declare_parameter(parameter, getattr(options, name), anything)
        self.options = options
        given = [node.get_parameter(parameter) for parameter in names]
        self.options = self._with(given)
        node.set_parameters(self._converted(given))
        for parameter, one in self._options.items():  # from now on, mistakes get our own messages
            node.set_descriptor(parameter, _described(one, parameter in fixed))
        node.add_pre_set_parameters_callback(self._converted)
        node.add_on_set_parameters_callback(self._judged)
        node.add_post_set_parameters_callback(self._take_over)

    def follow(self, options: Any) -> None:
        """Take over what has changed in the options of the whole fleet, without a message."""
        self._is_quiet = True
        values = {
            parameter: value
            for parameter, name in self._names.items()
            if (value := getattr(options, name)) != getattr(self._followed, name)
        }
        self._followed = options
        self._node.set_parameters([Parameter(name, value=value) for name, value in values.items()])
        self._is_quiet = False

    def _converted(self, parameters: Iterable[Parameter]) -> list[Parameter]:
        """Return parameters with whole numbers converted where real numbers are expected."""
        return [
            Parameter(one.name, value=self._options[one.name].kind.value(one.value))
            if type(one.value) is int and one.name in self._options
            else one
            for one in parameters
        ]

    def _with(self, parameters: Iterable[Parameter]) -> Group:
        """Return the options with new values of parameters, or raise SetcmasError."""
        values = {}
        for one in self._converted(parameters):
            if one.name in self._names:
                self._options[one.name].kind.check(f'parameter {one.name}', one.value)
                values[self._names[one.name]] = one.value
        return replace(self.options, **values)

    def _judged(self, parameters: list[Parameter]) -> SetParametersResult:
        try:
            self._check(self._with(parameters))
        except SetcmasError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _take_over(self, parameters: list[Parameter]) -> None:
        before, self.options = self.options, self._with(parameters)
        if self.options != before and not self._is_quiet:
            own = [one for one in parameters if one.name in self._names]
            texts = [f'{one.name} is {str(one.value).removesuffix(".0")}' for one in own]
            name = self._node.get_fully_qualified_name()
            self._node.get_logger().info(f'{name}: {", ".join(texts)} from now on')


def warn_of_unknown(nodes: Sequence[Node]) -> None:
    """Warn of parameters in `--ros-args` that none of the nodes of a process has."""
    known = {name for node in nodes for name in node.get_parameters_by_prefix('')}
    given = {name for node in nodes for name in node._parameter_overrides}
    for name in sorted(given - known):
        if not name.startswith('qos_overrides.'):
            hint = did_you_mean(name, known) or '; it is ignored'
            nodes[0].get_logger().warning(f"unknown parameter '{name}'{hint}")


def _described(option: Option, fixed: bool) -> ParameterDescriptor:
    # Dynamic typing: to ROS `-p vnom:=1` is an integer, which must be accepted.
    described = ParameterDescriptor(
        description=option.help,
        additional_constraints=option.kind.must_be,
        read_only=fixed,
        dynamic_typing=True,
    )
    described.type = ParameterType.PARAMETER_STRING
    if isinstance(option.kind, Number):
        described.type = ParameterType.PARAMETER_DOUBLE
        # To the C conversion of a message an int is no number but arbitrary bits.
        least = float(max(option.kind.above, option.kind.least))
        most = float(option.kind.most)
        described.floating_point_range = [FloatingPointRange(from_value=least, to_value=most)]
    return described
