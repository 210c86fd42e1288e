"""Writes the libraries of the page that runs laws: the editor, and the list of Pyodide's files.

python docs/generators/site_libraries.py     needs npm, and the network

The results are committed, with their digests in a test. CodeMirror 6 (MIT licence) is bundled
into one module; it works with screen readers, on phones, and leaves the page's keys alone. Pyodide
is only listed: pages get it from a content delivery network or from a folder.
"""

from __future__ import annotations

import hashlib
import json
import subprocess
import tarfile
from pathlib import Path
from tempfile import TemporaryDirectory

from generate import ROOT

SITE = ROOT / 'setcmas_tools' / 'setcmas_tools' / 'page' / 'templates' / 'site'

LIBRARIES = {
    '@codemirror/commands': '6.11.1',
    '@codemirror/lang-python': '6.2.1',
    '@codemirror/language': '6.13.1',
    '@codemirror/state': '6.7.6',
    '@codemirror/view': '6.43.15',
    '@lezer/highlight': '1.2.5',
}
ESBUILD = 'esbuild@0.28.2'
EXPORTS = """
export {
  Decoration, EditorView, drawSelection, highlightActiveLine, keymap, lineNumbers,
} from '@codemirror/view';
export {EditorState, StateEffect, StateField} from '@codemirror/state';
export {defaultKeymap, history, historyKeymap, indentWithTab} from '@codemirror/commands';
export {
  bracketMatching, indentOnInput, indentUnit, syntaxHighlighting,
} from '@codemirror/language';
export {python} from '@codemirror/lang-python';
export {classHighlighter} from '@lezer/highlight';
"""
HEAD = '/* CodeMirror 6 and Lezer: {versions}\n\n{licence}*/\n'

PYODIDE = '0.27.7'
CORE = ('pyodide.mjs', 'pyodide.asm.js', 'pyodide.asm.wasm', 'python_stdlib.zip')
FIRST, LATER = ('numpy', 'pyyaml'), ('matplotlib',)


def main() -> None:
    """Write both files."""
    with TemporaryDirectory() as name:
        (SITE / 'codemirror.js').write_text(codemirror(Path(name)))
    with TemporaryDirectory() as name:
        text = json.dumps(pyodide(Path(name)), indent=1)
        (SITE / 'pyodide.json').write_text(f'{text}\n')


def codemirror(folder: Path) -> str:
    """Return the bundle, with its licence."""
    (folder / 'package.json').write_text('{}')
    (folder / 'entry.js').write_text(EXPORTS)
    names = [f'{name}@{version}' for name, version in LIBRARIES.items()]
    run(folder, 'npm', 'install', '--save-exact', '--no-audit', *names, ESBUILD)
    options = ('--bundle', '--minify', '--format=esm', '--charset=utf8', '--legal-comments=none')
    run(folder, 'npx', 'esbuild', 'entry.js', *options, '--outfile=bundle.js')
    licence = (folder / 'node_modules' / '@codemirror' / 'view' / 'LICENSE').read_text()
    head = HEAD.format(versions=', '.join(names), licence=licence)
    return head + (folder / 'bundle.js').read_text()


def pyodide(folder: Path) -> dict[str, object]:
    """Return the files of Pyodide that pages need: digests, and the lock of the packages."""
    run(folder, 'npm', 'pack', f'pyodide@{PYODIDE}')
    with tarfile.open(folder / f'pyodide-{PYODIDE}.tgz') as archive:
        archive.extractall(folder, filter='data')
    package = folder / 'package'
    lock = json.loads((package / 'pyodide-lock.json').read_text())
    kept, waiting = {}, [*FIRST, *LATER]
    while waiting:
        name = waiting.pop().lower()
        if name not in kept:
            kept[name] = lock['packages'][name]
            waiting += kept[name]['depends']
    digests = {name: hashlib.sha256((package / name).read_bytes()).hexdigest() for name in CORE}
    return {'core': digests, 'lock': {**lock, 'packages': dict(sorted(kept.items()))}}


def run(folder: Path, *command: str) -> None:
    """Run a command in a folder."""
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)


if __name__ == '__main__':
    main()
