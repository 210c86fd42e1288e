"""The task `consensus`: all robots are to meet. It has no references."""

from __future__ import annotations

from setcmas_tools.kinds.task import Task

CONSENSUS = Task()
"""The task; the agreement of the fleet is measured in every run."""
