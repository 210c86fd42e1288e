// The editor: Python in colours, and a mark at a line with a mistake.

import {
  Decoration, EditorState, EditorView, StateEffect, StateField, bracketMatching, classHighlighter, defaultKeymap, drawSelection,
  highlightActiveLine, history, historyKeymap, indentOnInput, indentUnit, indentWithTab, keymap, lineNumbers, python, syntaxHighlighting,
} from './codemirror.js';

const setMark = StateEffect.define();
const marked = Decoration.line({class: 'mistake'});
const mark = StateField.define({
  create: () => Decoration.none,
  update(lines, change) {
    let marks = lines.map(change.changes);
    for (const effect of change.effects) if (effect.is(setMark)) marks = effect.value;
    return marks;
  },
  provide: field => EditorView.decorations.from(field),
});
let view = null;

// Create the editor; call `changed` after each change, and `run` for Ctrl+Enter.
export function createEditor(parent, changed, run) {
  const keys = [{key: 'Mod-Enter', run: () => { run(); return true; }}, ...defaultKeymap, ...historyKeymap, indentWithTab];
  view = new EditorView({parent, state: EditorState.create({extensions: [
    keymap.of(keys), history(), lineNumbers(), drawSelection(), highlightActiveLine(), indentOnInput(), bracketMatching(), python(),
    EditorView.lineWrapping, indentUnit.of('    '), EditorState.tabSize.of(4), syntaxHighlighting(classHighlighter), mark,
    EditorView.contentAttributes.of({'aria-label': 'Your script, in Python', 'aria-describedby': 'editor-keys', autocapitalize: 'off'}),
    EditorView.updateListener.of(update => { if (update.docChanged) changed(); }),
  ]})});
}

export const text = () => view.state.doc.toString();

// Replace the whole text; the user can undo it.
export function setText(text) {
  view.dispatch({changes: {from: 0, to: view.state.doc.length, insert: text}, selection: {anchor: 0}, effects: setMark.of(Decoration.none)});
}

// Mark a line, the first is 1, and bring it into sight; 0 removes the mark.
export function markLine(number) {
  const isThere = number > 0 && number <= view.state.doc.lines;
  const from = isThere ? view.state.doc.line(number).from : 0;
  const scroll = isThere ? [EditorView.scrollIntoView(from, {y: 'center'})] : [];
  view.dispatch({effects: [setMark.of(isThere ? Decoration.set([marked.range(from)]) : Decoration.none), ...scroll]});
}

export function goToLine(number) {
  const line = view.state.doc.line(Math.max(1, Math.min(number, view.state.doc.lines)));
  view.dispatch({selection: {anchor: line.from}, effects: EditorView.scrollIntoView(line.from, {y: 'center'})});
  view.focus();
}
