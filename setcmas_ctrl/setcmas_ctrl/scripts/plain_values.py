"""Plain values in the text of a script, read without running it."""

from __future__ import annotations

import ast
from contextlib import suppress
from pathlib import Path
from typing import Any

from setcmas_simu.errors import SetcmasError


def plain_values(script: Path) -> dict[str, Any]:
    """Return the plain values that a script gives to names of its top level, without running it.

    Raises:
        SetcmasError: The script cannot be read, or is not Python.
    """
    try:
        body = ast.parse(script.read_bytes(), script.name).body
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError) as error:
        reason = str(error) or 'it is nested too deeply'
        raise SetcmasError(f"control script '{script}' cannot be read: {reason}") from error
    values = {}
    for node in body:
        if isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value:
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            if isinstance(target, ast.Name):
                with suppress(ValueError, TypeError, RecursionError, MemoryError):
                    values[target.id] = ast.literal_eval(node.value)
    return values
