// The page: an editor, settings, and buttons that run, check, save and hand in a law.

import {createEditor, markLine, setText, text} from './editor.js';
import {createForm, isSource, request, setValues, showSource, sourceOf, values} from './form.js';
import {checked, keep, kept, linkTo, workOf} from './link.js';
import './player/main.js';
import {find} from './player/canvas.js';
import {play} from './player/player.js';
import {Python} from './python.js';
import {lineOf, message, showCheck, showPlots, showRun} from './results.js';

const SILENCE_MS = {run: 15_000, check: 120_000};  // a run tells each of its steps, a check each of its runs
const KEEP_MS = 300;
const FIRST = 'law:consensus';
const SHARED = 'This law comes from a link. Read it before you run it.';
let python = null, source = FIRST, reached = null, loop = null, keeping = null;

const work = () => ({name: find('file-name').value, text: text(), source, values: values(), set: find('set').value});
const status = text => { find('status').textContent = text; };

// Errors, marked in the editor.
function showError(text) {
  find('problem').replaceChildren(...(text ? [message(text)] : []));
  markLine(lineOf(text));
}

// The text and the settings survive a reload.
function changed() {
  clearTimeout(keeping);
  keeping = setTimeout(save, KEEP_MS);
}
function save() {
  clearTimeout(keeping);
  if (!keep(work())) status('This browser keeps nothing for this page: save your script before you leave.');
}
window.addEventListener('pagehide', () => { if (python) save(); });

function isOwn() {
  const now = text();
  return now.trim() !== '' && now !== sourceOf(source)?.text;
}
function take({name, text, source: from, values, set}) {
  source = from;
  setText(text);
  find('file-name').value = name;
  if (values) setValues(values);
  if (set !== undefined) find('set').value = set;
  showSource(source);
  showError('');
  save();
}
// Take other work; the user is asked if own text would go.
function offer(other, why) {
  const same = other.text === text();
  if (same || !isOwn()) { take(other); status(why); return; }
  find('question-text').textContent = `Replace your text by ${other.name}? ${why}`;
  find('question').hidden = false;
  find('replace').onclick = () => { answer(); take(other); status(`${why} Ctrl+Z brings your text back.`); };
  find('hold').onclick = answer;
  find('replace').focus();
}
function answer() {
  find('question').hidden = true;
  showSource(source);
}
function workFrom(key) {
  const {name, text} = sourceOf(key);
  return {name, text, source: key};
}

// Addresses: #law=consensus, #exercise=consensus, #code=... They run nothing.
async function followAddress() {
  const [, kind, value] = /^#(law|exercise|rubric|template|code)=([\w.-]*)$/.exec(location.hash) || [];
  if (!kind) return;
  history.replaceState(null, '', location.pathname + location.search);
  const key = `${kind}:${value}`;
  if (kind !== 'code') {
    if (isSource(key)) offer(workFrom(key), ''); else showError(`This page has no ${kind} '${value}'; choose one from the list.`);
    return;
  }
  try {
    const other = await workOf(value);
    offer({...other, source: isSource(other.source) ? other.source : 'template:'}, SHARED);
  } catch {
    showError('The link is damaged or incomplete; ask for it again.');
  }
}

// Calls of Python.
const CALLS = ['do-run', 'do-check', 'do-plots', 'save-run', 'save-report'];
function setBusy(busy) {
  for (const id of CALLS) find(id).disabled = busy;
  find('do-stop').disabled = !busy;
  find('progress').hidden = !busy;
  if (busy) find('progress').removeAttribute('value');
}
function hear({print, warn, reached: t, of, scenario, loading, loops}) {
  if (print) find('printed').append(print);
  if (warn) find('warnings').append(message(warn, 'note'));
  if (t !== undefined) { reached = t; Object.assign(find('progress'), {max: of, value: t}); status(`Running: t = ${t.toFixed(1)} of ${of} s`); }
  if (loops) { loop = loops; python.end('silent'); }
  if (scenario) status(`Checking: ${scenario}`);
  if (loading) status('Loading the parts for plots (10 MB, the first time) ...');
  find('output').hidden = !find('printed').textContent;
}
function endedText(reason, limit) {
  if (reason !== 'silent') return reason;
  const when = reached === null ? '' : ` after t = ${reached.toFixed(1)} s`, where = loop ? `${loop}: this loop` : 'The script';
  return `${where} has not ended within ${limit / 1000} s${when}, and was stopped. Look for a condition that never changes.`;
}
async function call(name, asked, show) {
  if (!find('do-stop').disabled) return;
  const limit = SILENCE_MS[name] ?? Infinity;
  reached = loop = null;
  setBusy(true);
  if (name in SILENCE_MS) {
    showError('');
    find('printed').textContent = '';
    for (const id of ['warnings', 'check-marks']) find(id).replaceChildren();
    find('output').hidden = true;
  }
  try {
    status(python.started ? 'Running ...' : 'Loading Python ...');
    const found = await python.call(name, asked, limit);
    if (found.ok === false) { showError(found.error); status('Stopped: see the message.'); } else { status('Ready.'); show(found); }
  } catch (error) {
    if (error.message !== 'stopped') showError(endedText(error.message, limit));
    status(error.message === 'stopped' ? 'Stopped.' : 'Stopped: see the message.');
    prepare();
  }
  setBusy(false);
}
function prepare() {
  python.start().then(() => { if (find('do-stop').disabled) status('Ready.'); }, error => {
    if (error.message !== 'stopped') { showError(error.message); status('Stopped: see the message.'); }
  });
}
const lawOf = () => ({script: text(), name: find('file-name').value.trim()});
function run() {
  let asked;
  try { asked = {...lawOf(), ...request(source)}; } catch (error) { showError(error.message); return; }
  call('run', asked, found => {
    showRun(found);
    const [failure] = found.failures;
    markLine(failure?.line || 0);
    if (matchMedia('(max-width: 59.9rem)').matches) find('results').scrollIntoView();  // they are below the editor
    if (!matchMedia('(prefers-reduced-motion: reduce)').matches) play(true);
  });
}
const check = () => call('check', {...lawOf(), ...(sourceOf(source)?.checks || {})}, showCheck);
const plots = () => call('plots', {}, found => showPlots(found.plots));

// What leaves the page: files and links.
function download(name, content, type) {
  const address = URL.createObjectURL(new Blob([content], {type}));
  Object.assign(document.createElement('a'), {href: address, download: name}).click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}
const stem = () => find('file-name').value.replace(/\.py$/, '') || 'my_law';
function saveReport() {
  const cover = {title: find('report-title').value.trim(), name: find('report-name').value.trim()};
  call('report_html', cover, found => download(`${stem()}.html`, found.html, 'text/html'));
}
async function copyLink() {
  try {
    const link = await linkTo(work());
    find('link-text').hidden = false;
    find('link-text').value = link;
    find('link-text').select();
    await navigator.clipboard?.writeText(link).then(() => status('The link is copied.'), () => status('Copy the link below.'));
  } catch (error) {
    showError(error.message);
  }
}
async function openFile() {
  const [file] = find('open-file').files;
  if (file) offer({...checked({...work(), name: file.name, text: await file.text()}), values: undefined, set: undefined}, '');
  find('open-file').value = '';
}

const CLICKS = {
  'do-run': run, 'do-check': check, 'do-plots': plots, 'copy-link': copyLink, 'save-report': saveReport,
  'do-stop': () => python.end('stopped'),
  'save-law': () => download(`${stem()}.py`, text(), 'text/x-python'),
  'save-run': () => call('run_zip', {}, found => download(`${stem()}_run.zip`, found, 'application/zip')),
};

async function begin() {
  const [catalogue, parts] = await Promise.all(['catalogue.json', 'python.json'].map(async name => (await fetch(name)).json()));
  python = new Python(parts, hear);
  prepare();  // it takes longest
  createForm(catalogue, changed);
  createEditor(find('editor'), changed, run);
  for (const [id, does] of Object.entries(CLICKS)) find(id).addEventListener('click', does);
  find('open-file').addEventListener('change', openFile);
  find('file-name').addEventListener('input', changed);
  find('source').addEventListener('change', () => offer(workFrom(find('source').value), ''));
  const before = kept(), first = isSource(catalogue.first) ? catalogue.first : FIRST;
  setValues();
  take(before ? {...before, source: isSource(before.source) ? before.source : 'template:'} : workFrom(first));
  setBusy(false);
  status('Loading Python ...');
  await followAddress();
  window.addEventListener('hashchange', followAddress);
  document.body.classList.add('begun');
}
begin();
