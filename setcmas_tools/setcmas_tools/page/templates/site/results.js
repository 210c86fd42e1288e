// Results: the run in the player, failures, metrics, plots, and the marks of a check. All texts are shown as texts.

import {find} from './player/canvas.js';
import {byNumber} from './player/history.js';
import {move, open, player} from './player/player.js';
import {goToLine} from './editor.js';

export function element(tag, textContent = '', className = '') {
  return Object.assign(document.createElement(tag), {textContent, className});
}
function button(text, does, className = '') {
  const made = element('button', text, className);
  made.addEventListener('click', does);
  return made;
}
function section(id, title, ...parts) {
  find(id).replaceChildren(...(title ? [element('h2', title), ...parts] : parts));
}

// The line of the script that a message names; 0 if it names none.
export const lineOf = text => +(/\.py, line (\d+)/.exec(text)?.[1] ?? 0);
// A message with a button for its line; `note` tells a mistake from a hint.
export function message(text, className = 'note failure') {
  const box = element('div', '', className), [first, ...more] = text.split('\n'), line = lineOf(text);
  box.append(element('p', first));
  if (more.length) box.append(element('pre', more.join('\n')));
  if (line) box.append(button(`line ${line}`, () => goToLine(line), 'time'));
  return box;
}

export function showRun({page, title, outcome, well, failures, metrics, seconds}) {
  find('results').classList.remove('empty');
  find('run-title').textContent = title;
  Object.assign(find('run-outcome'), {textContent: outcome, className: `outcome ${well ? 'good' : 'bad'}`});
  open(page);
  section('failures', '', ...failures.map(failureBox));
  section('metrics', 'Metrics', ...metrics.lines.map(line => element('p', line)), table(metrics));
  showPlots(null);
  find('took').textContent = `Simulated in ${seconds.toFixed(2)} s.`;
}

function failureBox({robot, t, text}) {
  const box = message(text);
  box.prepend(button(`robot ${robot}, t = ${t} s`, () => {
    player.selected = byNumber.get(robot) || null;
    move(t);
  }, 'time'));
  return box;
}

function table({headers, rows}) {
  const made = element('table'), box = element('div', '', 'scroll metrics');
  const head = made.createTHead().insertRow(), body = made.createTBody();
  for (const text of headers) head.append(Object.assign(element('th', text), {scope: 'col'}));
  for (const row of rows) {
    const line = body.insertRow();
    for (const text of row) line.insertCell().textContent = text;
  }
  box.append(made);
  return box;
}

function picture(source, alt, share = 1) {  // of this form only: no other address is asked for one
  const made = Object.assign(new Image(), {src: /^data:image\/png;base64,/.test(source) ? source : '', alt});
  made.style.setProperty('--share', share);
  return made;
}
export function showPlots(plots) {
  find('do-plots').hidden = plots !== null || find('results').classList.contains('empty');
  const box = element('div', '', 'plots scroll');
  if (plots) box.append(...plots.map(one => picture(one.url, one.name, one.share)));
  section('plots', plots ? 'Plots' : '', ...(plots ? [box] : []));
}

// The marks as `setcmas check --json` has them, with a picture.
export function showCheck({status, score: points, max_score: most, marks: {title, scenarios}, picture: source}) {
  const score = element('p', `${points} of ${most} points`, `score ${points === most ? 'good' : points ? 'some' : 'bad'}`);
  const {hint} = scenarios.flatMap(one => one.criteria).find(one => one.hint) || {};
  const note = status === 'unfilled' ? 'The blanks are not filled in yet: replace the parts marked TODO.' : hint && `Hint: ${hint}`;
  const parts = [score, ...(note ? [message(note, 'note')] : []), ...scenarios.map(scenarioPart)];
  if (source) parts.push(picture(source, `Paths of ${title}: your law and the solution`));
  find('none').hidden = true;
  section('check-marks', `Check: ${title}`, ...parts);
  find('check-marks').scrollIntoView({block: 'nearest'});
}
const sum = numbers => +numbers.reduce((one, other) => one + other, 0).toFixed(2);
function scenarioPart({name, failure, criteria}) {
  const box = element('div', '', 'scenario'), list = element('ul');
  for (const one of criteria) {
    const isFull = one.points === one.max_points, row = element('li', '', isFull ? 'met' : 'missed');
    row.append(element('span', isFull ? '✓ ' : '✗ ', isFull ? 'good' : 'bad'), element('span', `${one.name}: ${one.points} of ${one.max_points}`));
    row.append(element('span', ` ${one.reached_text}, wanted ${one.wanted}`, 'soft'));
    list.append(row);
  }
  const points = sum(criteria.map(one => one.points)), most = sum(criteria.map(one => one.max_points));
  box.append(element('h3', `${name}: ${points} of ${most} points`), ...(failure ? [message(failure.message)] : []), list);
  return box;
}
