"""Chromium with Pyodide, in which `site_worker` answers calls, without a network."""

import contextlib
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from browser import open_browser
from pyodide_folder import pyodide_folder
from served_folder import served

from setcmas_tools.grade.rubric_handout import archive
from setcmas_tools.page.site_folder import SETCMAS, installed_packages

_BOOT = """
const done = arguments[arguments.length - 1], laps = {};
let begin = performance.now();
const lap = name => {
  const now = performance.now();
  laps[name] = (now - begin) / 1e3;
  begin = now;
};
(async () => {
  const {loadPyodide} = await import('/pyodide/pyodide.mjs');
  window.py = await loadPyodide({indexURL: '/pyodide/'});
  lap('Pyodide');
  await py.loadPackage(['numpy', 'pyyaml']);
  lap('numpy and PyYAML');
  py.unpackArchive(await (await fetch('/setcmas.zip')).arrayBuffer(), 'wheel');
  lap('setcmas');
  window.said = [];
  py.globals.set('say', text => { said.push(JSON.parse(text)); });
  py.runPython('from setcmas_tools.page import site_worker');
  lap('imports');
  return laps;
})().then(done, error => done(String(error)));
"""
_CALL = """
const [name, request] = arguments, done = arguments[arguments.length - 1];
said.length = 0;
py.globals.set('request', JSON.stringify(request));
try {
  const begin = performance.now();
  const answer = JSON.parse(py.runPython(`site_worker.answer("${name}", request, say)`));
  answer.took = (performance.now() - begin) / 1e3;
  done([answer, said]);
} catch (error) { done([String(error), said]); }
"""
_PYTHON = """
const done = arguments[arguments.length - 1];
try { done(py.runPython(arguments[0])); } catch (error) { done(String(error)); }
"""
_MATPLOTLIB = """
const done = arguments[arguments.length - 1];
py.loadPackage('matplotlib').then(() => done('ready'), error => done(String(error)));
"""


class PyodideBrowser:
    """The browser; matplotlib is loaded when an answer asks for it.

    Attributes:
        laps: Durations in s of the parts of its start.
        packages: The archive of setcmas.
    """

    def __init__(self, browser, packages: Path) -> None:
        browser.set_script_timeout(120)
        self._browser = browser
        self.packages = packages
        self.laps = browser.execute_async_script(_BOOT)
        assert isinstance(self.laps, dict), self.laps

    def call(self, call: str, **request: Any):
        """Call a function of `site_worker`; return its answer and what it said meanwhile."""
        answer, said = self._browser.execute_async_script(_CALL, call, request)
        if isinstance(answer, dict) and answer.get('needs') == 'matplotlib':
            self.load_matplotlib()
            return self.call(call, **request)
        return answer, said

    def python(self, code: str):
        """Return the value of Python code."""
        return self._browser.execute_async_script(_PYTHON, code)

    def load_matplotlib(self) -> None:
        """Load matplotlib, but do not import it."""
        assert self._browser.execute_async_script(_MATPLOTLIB) == 'ready'

    def memory_mb(self) -> float:
        """Return the size of Pyodide's memory in MB."""
        return self._browser.execute_script('return py._module.HEAPU8.length / 1e6')


@contextlib.contextmanager
def pyodide_browser() -> Iterator[PyodideBrowser]:
    """Start it."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / SETCMAS).write_bytes(archive(installed_packages()))
        (folder / 'index.html').write_text('<!doctype html><title>Test</title>')
        (folder / 'pyodide').symlink_to(pyodide_folder())
        with served(folder) as address, open_browser(800, 600) as browser:
            browser.get(address)
            yield PyodideBrowser(browser, folder / SETCMAS)
