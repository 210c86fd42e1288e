// The run: poses, states, links, broadcasts and drawings, at any of its times.

export let run, robots;
export let times;  // s, sorted
export const shapes = [];  // what scripts drew: from and to, the times between which it is there
export const TINY = 1e-6;
const SERIES = ['x', 'y', 'theta', 'v', 'omega'];
const MOST_POSES = 600_000;  // of a live run; the oldest go first
export const byNumber = new Map();

// JSON has null where a number is not known.
const numbers = values => values.map(value => value ?? NaN);

// A value for each place, from the places where it changes.
function spread(changes, count) {
  return changes.flatMap(([place, value], k) => {
    const end = k + 1 < changes.length ? changes[k + 1][0] : count;
    return Array(end - place).fill(value);
  });
}

export function addRobot(look) {
  const robot = {...look, leg: [], states: [], sent: []};
  for (const name of SERIES) robot[name] = Array(times.length).fill(NaN);
  robot.leg = Array(times.length).fill(0);
  robots.push(robot);
  robots.sort((a, b) => a.number - b.number);
  byNumber.set(robot.number, robot);
  return robot;
}

function unpackRobot(robot) {
  for (const name of SERIES) robot[name] = numbers(robot[name]);
  const breaks = new Set(robot.breaks);
  let leg = 0;
  robot.leg = times.map((_, k) => breaks.has(k) ? ++leg : leg);
  robot.sent = numbers(run.plane.sent[robot.number] || []);
  robot.states = [];
}

function unpackCalls(calls) {
  for (const name of ['t', 'vx', 'vy', 'allowedX', 'allowedY']) if (calls[name]) calls[name] = numbers(calls[name]);
  calls.words = spread(calls.words, calls.t.length);
}

function unpackDrawn(drawn) {
  const [t, x, y] = ['t', 'x', 'y'].map(name => numbers(drawn[name])), looks = spread(drawn.looks, t.length);
  t.forEach((from, k) => {
    const [size, colour, alpha] = looks[k], to = drawn.marker && k + 1 < t.length ? t[k + 1] : Infinity;
    shapes.push({kind: 'discs', from, to, moves: drawn.marker, places: [[x[k], y[k]]], size, colour, alpha});
  });
}

// Take the content of a run, which is unpacked in place; it replaces the run before.
export function openRun(content) {
  run = content;
  ({t: times, robots} = run);
  forgetShapes();
  for (const robot of robots) {
    unpackRobot(robot);
    byNumber.set(robot.number, robot);
  }
  Object.values(run.calls).forEach(unpackCalls);
  run.plane.drawings.forEach(unpackDrawn);
  shapes.sort((a, b) => a.from - b.from);
  for (const {values} of run.charts) for (const number in values) values[number] = numbers(values[number]);
}
function forgetShapes() {
  shapes.length = 0;
  byNumber.clear();
  current.clear();
  Object.assign(links, {t: -Infinity, place: 0, weights: new Map()});
}

// How many of sorted numbers are at or before a value.
export function countUntil(sorted, value) {
  let low = 0, high = sorted.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= value + TINY) low = middle + 1; else high = middle;
  }
  return low;
}
export function shapesUntil(t) {  // how many begin at or before a time
  let low = 0, high = shapes.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (shapes[middle].from <= t + TINY) low = middle + 1; else high = middle;
  }
  return low;
}
export const first = () => times.length ? times[0] : 0;
export const last = () => times.length ? times[times.length - 1] : 0;
export const indexAt = t => Math.max(0, Math.min(times.length - 1, countUntil(times, t) - 1));
export const wrapped = angle => Math.atan2(Math.sin(angle), Math.cos(angle));

// A robot between two of its poses, the first of which has a place; null where it is not known.
export function poseAt(robot, t, k = indexAt(t)) {
  const next = k + 1, x = robot.x[k];
  if (!times.length || isNaN(x)) return null;
  const pose = {x, y: robot.y[k], theta: robot.theta[k], v: robot.v[k], omega: robot.omega[k]};
  const part = next < times.length ? Math.min(1, Math.max(0, (t - times[k]) / (times[next] - times[k]))) : 0;
  if (part < TINY || robot.leg[next] !== robot.leg[k] || isNaN(robot.x[next])) return pose;
  pose.x += part * (robot.x[next] - pose.x);
  pose.y += part * (robot.y[next] - pose.y);
  pose.theta += part * wrapped(robot.theta[next] - pose.theta);
  return pose;
}

// The newest call of a robot's law, and its place among the calls; null if there is none.
export function callAt(robot, t) {
  const calls = run.calls[robot.number], place = calls ? countUntil(calls.t, t) - 1 : -1;
  if (place < 0) return null;
  const [kind, words] = calls.words[place];
  return {calls, place, kind, words, t: calls.t[place], vx: calls.vx[place], vy: calls.vy[place]};
}

// What became of a robot: a kind for the colour, a label for the table, and a sentence.
export function stateAt(robot, t) {
  const call = callAt(robot, t);
  if (call) return {kind: call.kind, label: call.kind, words: call.words};
  const place = countUntil(robot.states.map(state => state.t), t) - 1;
  return place < 0 ? {kind: '', label: '', words: ''} : robot.states[place];
}

export const lastSent = (robot, t) => robot.sent[countUntil(robot.sent, t) - 1];

// The links at a time by 'receiver sender': receiver, sender and weight. Continues from the time of the last call.
const links = {t: -Infinity, place: 0, weights: new Map()};
export function linksAt(t) {
  const changes = run.plane.links || [];
  if (t < links.t) Object.assign(links, {place: 0, weights: new Map()});
  for (links.t = t; links.place < changes.length && changes[links.place][0] <= t + TINY; links.place++) {
    const [, receiver, sender, weight] = changes[links.place], pair = `${receiver} ${sender}`;
    if (weight) links.weights.set(pair, [receiver, sender, weight]); else links.weights.delete(pair);
  }
  return links.weights;
}

// The lines below are for a run that goes on.

export function forgetAll() {
  for (const list of [times, robots, run.clock ||= [], run.plane.links ||= []]) list.length = 0;
  for (const chart of run.charts) for (const number in chart.values) delete chart.values[number];
  forgetShapes();
}

// A message of poses: numbers of robots with x, y, theta and v of each; robots that were moved there; the run's time.
export function addFrame({t, numbers, poses, put, clock, curves}) {
  if (times.length && t <= last()) return;
  times.push(t);
  run.clock.push(clock ?? NaN);
  const places = new Map(numbers.map((number, place) => [number, place])), moved = new Set(put);
  for (const robot of robots) {
    const place = places.get(robot.number), known = place !== undefined;
    ['x', 'y', 'theta', 'v'].forEach((name, part) => robot[name].push(known ? poses[4 * place + part] : NaN));
    robot.omega.push(NaN);
    robot.leg.push((robot.leg.at(-1) || 0) + moved.has(robot.number));
  }
  run.charts.forEach((chart, n) => (chart.values[0] ||= Array(times.length - 1).fill(NaN)).push(curves[n] ?? NaN));
  if (times.length * robots.length > MOST_POSES) forgetOldest(times.length >> 2);
}

function forgetOldest(count) {
  for (const list of [times, run.clock, ...run.charts.flatMap(chart => Object.values(chart.values))]) list.splice(0, count);
  for (const robot of robots) {
    for (const name of [...SERIES, 'leg']) robot[name].splice(0, count);
    robot.states.splice(0, countUntil(robot.states.map(state => state.t), first()) - 1);
    robot.sent.splice(0, countUntil(robot.sent, first()));
  }
  const kept = shapes.filter(shape => shape.to >= first());
  shapes.splice(0, shapes.length, ...kept);
  const weights = linksAt(first()), changes = run.plane.links.slice(links.place);
  run.plane.links = [...[...weights.values()].map(link => [-Infinity, ...link]), ...changes];
  Object.assign(links, {t: -Infinity, place: 0, weights: new Map()});
}

export function addState(number, state) { byNumber.get(number)?.states.push(state); }
export function addSent(number, t) { byNumber.get(number)?.sent.push(t); }
export function addLink(...change) { run.plane.links.push(change); }  // time, receiver, sender, weight

// Shapes that replace those of the same keys; null removes. One that has replaced another will probably be replaced, too.
const current = new Map();
let ended = 0;
export const endedShapes = () => ended;  // how many that seemed to stay
export function addShape(key, t, shape) {
  const before = current.get(key);
  if (before) before.to = t;
  if (before && !before.moves) ended++;
  current.delete(key);
  if (!shape) return;
  const added = {...shape, from: t, to: Infinity, moves: before !== undefined};
  shapes.push(added);
  current.set(key, added);
}

openRun(JSON.parse(document.getElementById('run').textContent));
export const isLive = run.live !== null;
