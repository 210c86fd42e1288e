// The form: where to start from, and the settings of the run.

import {find} from './player/canvas.js';

const FIRST = ['nb_robots', 'duration', 'graph', 'delay', 'loss', 'event_triggered'];
const START = {nb_robots: '8'};
const inputs = new Map();  // by the name of the option
let sources = new Map();  // by 'law:consensus': file name, text, and the request's parts

function element(tag, parts = {}, ...children) {
  const made = Object.assign(document.createElement(tag), parts);
  made.append(...children);
  return made;
}

// Fill in the choices of a catalogue; call `changed` after each change of a setting.
export function createForm(catalogue, changed) {
  sources = new Map(catalogue.sources.map(one => [one.key, one]));
  const groups = new Map();
  for (const [key, {group, label}] of sources) {
    if (!groups.has(group)) groups.set(group, element('optgroup', {label: group}));
    groups.get(group).append(element('option', {value: key, textContent: label}));
  }
  find('source').append(...groups.values());
  for (const option of catalogue.options) addOption(option, changed);
  find('set').addEventListener('input', changed);
}

export const sourceOf = key => sources.get(key);
export const isSource = key => sources.has(key);

function addOption({name, help, must_be, input, default: default_, default_text, unit, choices}, changed) {
  let field;
  if (input === 'choice') {
    field = element('select');
    for (const choice of choices) field.append(element('option', {value: choice === default_ ? '' : choice, textContent: choice}));
  } else if (input === 'switch') field = element('input', {type: 'checkbox'});
  else {
    field = element('input', {type: 'text', placeholder: default_text || (default_ === null || default_?.length === 0 ? '' : String(default_)), spellcheck: false});
    if (input !== 'text' && input !== 'several') field.inputMode = 'decimal';
  }
  Object.assign(field, {id: `option-${name}`, title: must_be === 'a text' ? help : `${help}: ${must_be}`});
  field.addEventListener('input', changed);
  inputs.set(name, {field, isSeveral: input === 'several'});
  const label = name.replace(/^nb_/, '').replaceAll('_', ' ') + (unit ? ` (${unit})` : '');
  const parts = input === 'switch' ? [field, ` ${label}`] : [`${label} `, field];
  find(FIRST.includes(name) ? 'first-options' : 'more-options').append(element('label', {className: input}, ...parts));
}

const valueOf = ({field}) => field.type === 'checkbox' ? field.checked : field.value.trim();

// The values that are not the defaults, as texts and booleans.
export function values() {
  return Object.fromEntries([...inputs].map(([name, one]) => [name, valueOf(one)]).filter(([, value]) => value !== '' && value !== false));
}
export function setValues(chosen = START) {
  for (const [name, {field}] of inputs) {
    const value = chosen[name] ?? '';
    if (field.type === 'checkbox') field.checked = value === true || value === 'true';
    else field.value = Array.isArray(value) ? value.join(' ') : String(value);
    if (field.tagName === 'SELECT' && field.selectedIndex < 0) field.selectedIndex = 0;
  }
}
export function showSource(key) {
  find('source').value = key;
  const names = sourceOf(key)?.settings || [];
  find('set').placeholder = names.length ? `${names[0]}=2` : 'NAME=VALUE';
  find('set-names').textContent = names.length ? `Numbers of this law: ${names.join(', ')}.` : '';
}

// The part of a request for `run` that the form decides.
export function request(key) {
  const source = sourceOf(key) || {}, scenario = values(), set = {};
  for (const [name, {isSeveral}] of inputs) if (isSeveral && scenario[name]) scenario[name] = scenario[name].split(/\s+/);
  for (const line of find('set').value.split('\n')) {
    if (!line.trim()) continue;
    const [, setting, value] = /^\s*([^=]*?)\s*=\s*(.*?)\s*$/.exec(line) || [];
    if (!setting) throw new Error(`'${line.trim()}' must have the form NAME=VALUE, such as K=2`);
    set[setting] = value;
  }
  return {scenario, set, function: source.function ?? null};
}
