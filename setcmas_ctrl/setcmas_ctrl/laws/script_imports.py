"""Imports of control scripts: every robot gets modules of its own."""

from __future__ import annotations

import ast
import builtins
import contextlib
import os
import sys
import threading
import types
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from pathlib import Path
from typing import Any

from setcmas_ctrl.laws.drawing import rviz_marker, rviz_marker_array
from setcmas_simu.errors import SetcmasError
from setcmas_simu.limited_file import read_limited

MOST_BYTES = 2_000_000
"""Largest script."""

_OWNER = '__setcmas_imports__'
_DRAWING = {'rviz_marker': rviz_marker, 'rviz_marker_array': rviz_marker_array}
_LOCK = threading.RLock()


def robot_of_frame(frame: types.FrameType) -> int | None:
    """Return the robot whose script or helper module a frame runs; None for other code."""
    imports = frame.f_builtins.get(_OWNER)
    return imports.robot if imports else None


def calling_robot() -> int | None:
    """Return the robot whose script has called, directly or not; None if no script has."""
    frame: types.FrameType | None = sys._getframe(1)
    while frame is not None:
        if (robot := robot_of_frame(frame)) is not None:
            return robot
        frame = frame.f_back
    return None


class ScriptImports:
    """Imports of a robot's script: a finder of `sys.meta_path`."""

    def __init__(self, folder: Path, robot: int) -> None:
        self.robot = robot
        self._folder = str(folder)
        self._modules: dict[str, types.ModuleType] = dict(_DRAWING)
        self._found: set[str] = set()
        self._depth = 0
        self.builtins = {**vars(builtins), _OWNER: self, '__import__': self._import}

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: types.ModuleType | None = None
    ) -> ModuleSpec | None:
        """Find a module in the script's folder, or in a package there (called by Python)."""
        del target
        if path is not None and name.partition('.')[0] not in self._found:
            return None
        spec = PathFinder.find_spec(name, path or [self._folder])
        if spec is None or (path is None and self._is_mere_folder(spec)):
            return None
        if isinstance(spec.loader, SourceFileLoader):
            spec.loader = _HelperLoader(name, spec.loader.path, self.builtins)
        self._found.add(name)
        return spec

    def _is_mere_folder(self, spec: ModuleSpec) -> bool:
        """Return whether a folder without __init__.py would hide an installed package."""
        if spec.origin is not None:
            return False
        installed = PathFinder.find_spec(spec.name)
        return installed is not None and installed.origin is not None

    def _import(
        self,
        name: str,
        globals: Mapping[str, object] | None = None,  # noqa: A002 (Python's own names)
        locals: Mapping[str, object] | None = None,  # noqa: A002
        fromlist: Sequence[str] | None = (),
        level: int = 0,
    ) -> types.ModuleType:
        root = name.partition('.')[0]
        if level == 0:
            module = self._modules.get(name)
            if module and all(hasattr(module, attribute) for attribute in fromlist or ()):
                return module if fromlist else self._modules[root]
            if root not in self._modules and (root in sys.modules or not self.find_spec(root)):
                return builtins.__import__(name, globals, locals, fromlist or (), level)
        with self._in_sys_modules():
            return builtins.__import__(name, globals, locals, fromlist or (), level)

    @contextlib.contextmanager
    def _in_sys_modules(self) -> Iterator[None]:
        """Show this robot's helper modules to Python's import, inside this context only."""
        with _LOCK:
            if self._depth == 0:
                sys.meta_path.insert(0, self)
                sys.modules.update(self._modules)
            self._depth += 1
            try:
                yield
            finally:
                self._depth -= 1
                if self._depth == 0:
                    sys.meta_path.remove(self)
                    for name in (self._found | _DRAWING.keys()) & sys.modules.keys():
                        self._modules[name] = sys.modules.pop(name)


class _HelperLoader(SourceFileLoader):
    """Loads a helper module with a robot's builtins."""

    def __init__(self, name: str, path: str, robot_builtins: dict[str, Any]) -> None:
        super().__init__(name, path)
        self._builtins = robot_builtins

    def get_code(self, fullname: str) -> types.CodeType:
        # Not from __pycache__: its time stamps are too coarse while a file is edited.
        path = self.get_filename(fullname)
        return self.source_to_code(self.get_data(path), path)

    def exec_module(self, module: types.ModuleType) -> None:
        module.__dict__['__builtins__'] = self._builtins
        super().exec_module(module)


def with_helpers(file: Path) -> list[Path]:
    """Return a file and, if it is a script, the helper modules in its folder that it imports."""
    return [file, *(helper_modules(file) if file.suffix == '.py' else [])]


def helper_modules(script: Path) -> list[Path]:
    """Return all modules in a script's folder that it imports, directly or not, sorted."""
    found = {script}
    waiting = [script]
    while waiting:
        new = set(_imported(waiting.pop(), script.parent)) - found
        found |= new
        waiting += new
    return sorted(found - {script})


def _imported(file: Path, folder: Path) -> Iterator[Path]:
    """Yield the files in a folder that a file may import."""
    try:
        statements = _import_statements(read_limited(file, MOST_BYTES))
    except (OSError, SetcmasError, SyntaxError, ValueError, RecursionError, MemoryError):
        return  # its error is reported when it is imported
    for node in statements:
        for base, name in _names(node, file, folder):
            path = base
            for part in name.split('.'):
                path = path / part
                places = (path.with_suffix('.py'), path / '__init__.py')
                yield from (place for place in places if place.is_file())


@lru_cache(maxsize=64)
def _import_statements(source: bytes) -> list[ast.Import | ast.ImportFrom]:
    nodes = ast.walk(ast.parse(source))
    return [node for node in nodes if isinstance(node, (ast.Import, ast.ImportFrom))]


def _names(node: ast.Import | ast.ImportFrom, file: Path, folder: Path) -> list[tuple[Path, str]]:
    """Return the modules that a statement imports, each with its folder."""
    if isinstance(node, ast.Import):
        return [(folder, alias.name) for alias in node.names]
    base = folder
    if node.level:
        # Not resolved: the folder may be reached by a symbolic link.
        base = Path(os.path.normpath(file.parent.joinpath(*['..'] * (node.level - 1))))
        if not base.is_relative_to(folder):
            return []
    prefix = f'{node.module}.' if node.module else ''
    return [(base, prefix + alias.name) for alias in node.names]
