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

// A message with a button for its line; `note` tells a mistake from a hint.
export function message(text, line = 0, className = 'note failure') {
  const box = element('div', '', className), [first, ...more] = text.split('\n');
  box.append(element('p', first));
  if (more.length) box.append(element('pre', more.join('\n')));
  if (line) box.append(button(`line ${line}`, () => goToLine(line), 'time'));
  return box;
}

export function showRun({page, title, outcome, well, links, failures, metrics, seconds}) {
  find('results').classList.remove('empty');
  find('run-title').textContent = title;
  Object.assign(find('run-outcome'), {textContent: outcome, className: `outcome ${well ? 'good' : 'bad'}`});
  find('links').parentElement.hidden = !links;
  open(page);
  section('failures', '', ...failures.map(failureBox));
  section('metrics', 'Metrics', ...metrics.lines.map(line => element('p', line)), table(metrics));
  showPlots(null);
  find('took').textContent = `Simulated in ${seconds.toFixed(2)} s.`;
}

function failureBox({robot, t, line, text}) {
  const box = message(text, line);
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
  if (plots) box.append(...plots.map(one => picture(one.picture, one.name, one.share)));
  section('plots', plots ? 'Plots' : '', ...(plots ? [box] : []));
}

export function showCheck({title, points, of, full, unfilled, hint, scenarios, picture: source}) {
  const score = element('p', `${points} of ${of} points`, `score ${full ? 'good' : points ? 'some' : 'bad'}`);
  const note = unfilled ? 'The blanks are not filled in yet: replace the parts marked TODO.' : hint && `Hint: ${hint}`;
  const parts = [score, ...(note ? [message(note, 0, 'note')] : []), ...scenarios.map(scenarioPart)];
  if (source) parts.push(picture(source, `Paths of ${title}: your law and the solution`));
  find('none').hidden = true;
  section('check-marks', `Check: ${title}`, ...parts);
  find('check-marks').scrollIntoView({block: 'nearest'});
}
function scenarioPart({name, points, failure, line, criteria}) {
  const box = element('div', '', 'scenario'), list = element('ul');
  for (const one of criteria) {
    const row = element('li', '', one.full ? 'met' : 'missed');
    row.append(element('span', one.full ? '✓ ' : '✗ ', one.full ? 'good' : 'bad'), element('span', `${one.name}: ${one.points} of ${one.of}`));
    row.append(element('span', ` ${one.reached}, wanted ${one.wanted}`, 'soft'));
    list.append(row);
  }
  box.append(element('h3', `${name}: ${points}`), ...(failure ? [message(failure, line)] : []), list);
  return box;
}
