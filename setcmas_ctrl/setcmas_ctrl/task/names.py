"""Tasks by name: the references that each takes from a control law."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from setcmas_simu.doors import Door, instance_of

Kind = Callable[[Any], Any]
"""Returns a reference as numbers and lists; raises ValueError, saying what it must be."""


@dataclass(frozen=True)
class TaskNames:
    """The references that a task takes from a control law.

    Attributes:
        names: The kind of each reference by its name.
        defaults: Values of those that a law may leave out; None leaves out the reference.
    """

    names: Mapping[str, Kind] = field(default_factory=dict)
    defaults: Mapping[str, Any] = field(default_factory=dict)


TASKS = Door('setcmas.tasks', 'task', instance_of(TaskNames))
"""The tasks that are installed; each is imported when a law says its name."""
