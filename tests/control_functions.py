"""The `control` of a script by itself, called without the checks of its results."""

from pathlib import Path

from setcmas_ctrl.laws.script_function import Control, checked_function
from setcmas_ctrl.laws.script_loader import load_script


def load_control(path: Path, robot: int) -> Control:
    """Run a script in a fresh module for one robot and return its `control`."""
    return checked_function(vars(load_script(path, robot)).get('control'), path)
