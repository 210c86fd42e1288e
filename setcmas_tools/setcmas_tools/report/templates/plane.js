// The plane: what a run was, unpacked, and robots, trails and drawings at a time.
'use strict';

const run = JSON.parse(document.getElementById('run').textContent);
const find = id => document.getElementById(id);
const plane = find('plane');
const times = run.t, step = times.length > 1 ? times[1] - times[0] : 1;
const first = times[0], last = times[times.length - 1];
const INK = '#1b1f24', SOFT = '#57606a', LINE = '#d8dee4';
const KINDS = {failed: '#cf222e', stopped: '#cf222e', overruled: '#8250df', saturated: '#bf8700'};
const FLASH_S = 0.5, MOST_NUMBERS = 20, KEPT = 1e-6;
let now = first, selected = null;

// What is packed: differences of whole numbers, null where nothing is known.
function unpacked(steps) {
  let sum = 0;
  return steps.map(each => each === null ? NaN : (sum += each) / run.scale);
}
// What is told where it changes, for each place.
function spread(changes, count) {
  return changes.flatMap(([place, value], k) => Array((k + 1 < changes.length ? changes[k + 1][0] : count) - place).fill(value));
}
for (const robot of [...run.robots, ...run.others]) {
  for (const name of ['x', 'y', 'theta', 'v', 'omega']) robot[name] = unpacked(robot[name]);
  robot.breaks = new Set(robot.breaks);
}
for (const calls of Object.values(run.calls)) {
  for (const name of ['t', 'vx', 'vy', 'allowedX', 'allowedY']) if (calls[name]) calls[name] = unpacked(calls[name]);
  for (const one of calls.known || []) { one.x = unpacked(one.x); one.y = unpacked(one.y); }
  calls.words = spread(calls.words, calls.t.length);
}
for (const drawn of run.plane.drawings) {
  for (const name of ['t', 'x', 'y']) drawn[name] = unpacked(drawn[name]);
  drawn.looks = spread(drawn.looks, drawn.t.length);
}
for (const robot in run.plane.sent) run.plane.sent[robot] = unpacked(run.plane.sent[robot]);
for (const chart of run.charts) for (const values of [chart.values, chart.other || {}])
  for (const robot in values) values[robot] = unpacked(values[robot]);

// How many of sorted numbers are at or before a value.
function countUntil(sorted, value) {
  let low = 0, high = sorted.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= value + KEPT) low = middle + 1; else high = middle;
  }
  return low;
}
const indexAt = t => Math.max(0, Math.min(times.length - 1, countUntil(times, t) - 1));

// A robot between two of its poses; undefined where it is not known.
function poseAt(robot, t) {
  const k = indexAt(t), part = Math.min(1, Math.max(0, (t - times[k]) / step)), next = k + 1;
  const whole = part < KEPT || next >= times.length || robot.breaks.has(next) || isNaN(robot.x[next]);
  const at = name => whole ? robot[name][k] : robot[name][k] + part * (robot[name][next] - robot[name][k]);
  const pose = {x: at('x'), y: at('y'), theta: at('theta'), v: robot.v[k], omega: robot.omega[k]};
  return isNaN(pose.x) ? undefined : pose;
}

// The newest call of a robot's law, and its place among the calls.
function callAt(robot, t) {
  const calls = run.calls[robot.number], place = calls ? countUntil(calls.t, t) - 1 : -1;
  if (place < 0) return null;
  const [kind, words] = calls.words[place];
  return {calls, place, kind, words, t: calls.t[place], vx: calls.vx[place], vy: calls.vy[place]};
}

// The part of the plane that is shown: all that ever is in it.
const frame = (() => {
  const xs = [], ys = [], take = (x, y) => { if (isFinite(x) && isFinite(y)) { xs.push(x); ys.push(y); } };
  for (const robot of [...run.robots, ...run.others]) robot.x.forEach((x, k) => take(x, robot.y[k]));
  for (const one of run.plane.references) one.points.forEach(point => take(...point));
  for (const one of run.plane.polygons) one.forEach(point => take(...point));
  for (const [x, y, r] of run.plane.discs) { take(x - r, y - r); take(x + r, y + r); }
  if (run.plane.arena) { const [a, b, c, d] = run.plane.arena; take(a, c); take(b, d); }
  const range = list => list.reduce(([low, high], one) => [Math.min(low, one), Math.max(high, one)], [Infinity, -Infinity]);
  const [[left, right], [bottom, top]] = xs.length ? [range(xs), range(ys)] : [[0, 1], [0, 1]];
  return {x: (left + right) / 2, y: (bottom + top) / 2, width: Math.max(1, right - left) * 1.12, height: Math.max(1, top - bottom) * 1.12};
})();
let scale = 1, originX = 0, originY = 0;
const px = x => originX + (x - frame.x) * scale, py = y => originY - (y - frame.y) * scale;

function sized(canvas) {
  const box = canvas.getBoundingClientRect(), ratio = window.devicePixelRatio || 1;
  const width = Math.round(box.width * ratio), height = Math.round(box.height * ratio);
  if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
  const pen = canvas.getContext('2d');
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, box.width, box.height);
  pen.font = '12px system-ui, sans-serif';
  pen.lineJoin = pen.lineCap = 'round';
  return {pen, width: box.width, height: box.height};
}
function path(pen, points, close) {
  pen.beginPath();
  points.forEach(([x, y], k) => k ? pen.lineTo(px(x), py(y)) : pen.moveTo(px(x), py(y)));
  if (close) pen.closePath();
}
function disc(pen, x, y, radius, fill, stroke) {
  pen.beginPath();
  pen.arc(px(x), py(y), radius, 0, 2 * Math.PI);
  if (fill) { pen.fillStyle = fill; pen.fill(); }
  if (stroke) { pen.strokeStyle = stroke; pen.stroke(); }
}
function roundStep(span, most) {
  const power = 10 ** Math.floor(Math.log10(span / most));
  return [1, 2, 5, 10].map(one => one * power).find(one => span / one <= most);
}

function drawGround(pen, width, height) {
  const gap = roundStep(Math.max(width, height) / scale, Math.max(4, Math.max(width, height) / 70));
  const digits = Math.max(0, -Math.floor(Math.log10(gap) + KEPT));
  pen.lineWidth = 1; pen.strokeStyle = LINE; pen.fillStyle = SOFT;
  const halfX = width / 2 / scale, halfY = height / 2 / scale;
  pen.textAlign = 'center';
  for (let k = Math.ceil((frame.x - halfX) / gap); k * gap < frame.x + halfX; k++) {
    pen.beginPath(); pen.moveTo(px(k * gap), 0); pen.lineTo(px(k * gap), height); pen.stroke();
    if (px(k * gap) > 40 && px(k * gap) < width - 40) pen.fillText((k * gap).toFixed(digits), px(k * gap), height - 5);
  }
  pen.textAlign = 'left';
  for (let k = Math.ceil((frame.y - halfY) / gap); k * gap < frame.y + halfY; k++) {
    pen.beginPath(); pen.moveTo(0, py(k * gap)); pen.lineTo(width, py(k * gap)); pen.stroke();
    if (py(k * gap) > 32 && py(k * gap) < height - 24) pen.fillText((k * gap).toFixed(digits), 4, py(k * gap) - 3);
  }
  pen.textAlign = 'right'; pen.fillText('x (m)', width - 4, height - 5);
  pen.textAlign = 'left'; pen.fillText('y (m)', 4, 12);
  const {arena, discs, polygons, references} = run.plane;
  pen.lineWidth = 1.5; pen.strokeStyle = '#8c959f'; pen.fillStyle = '#d0d7de';
  if (arena) { const [a, b, c, d] = arena; path(pen, [[a, c], [b, c], [b, d], [a, d]], true); pen.stroke(); }
  for (const corners of polygons) { path(pen, corners, true); pen.fill(); pen.stroke(); }
  for (const [x, y, r] of discs) disc(pen, x, y, r * scale, '#d0d7de', '#8c959f');
  for (const one of references) {
    pen.strokeStyle = one.colour; pen.lineWidth = 1.3;
    if (one.joined) { pen.setLineDash([2, 4]); path(pen, one.points); pen.stroke(); pen.setLineDash([]); }
    if (one.marked) for (const [x, y] of one.points) pen.strokeRect(px(x) - 4, py(y) - 4, 8, 8);
  }
}
function drawDrawings(pen) {
  for (const drawn of run.plane.drawings) {
    const count = countUntil(drawn.t, now);
    for (let k = drawn.marker ? Math.max(0, count - 1) : 0; k < count; k++) {
      const [diameter, colour, alpha] = drawn.looks[k];
      pen.globalAlpha = alpha;
      disc(pen, drawn.x[k], drawn.y[k], Math.max(2, diameter / 2 * scale), colour);
    }
  }
  pen.globalAlpha = 1;
}
function drawLinks(pen) {
  if (!run.plane.links) return;
  const up = new Map();
  for (const [t, receiver, sender, weight] of run.plane.links) if (t <= now + KEPT) up.set(receiver + ' ' + sender, weight);
  const at = new Map(run.robots.map(robot => [robot.number, poseAt(robot, now)]));
  pen.lineWidth = 1; pen.strokeStyle = `rgba(87, 96, 106, ${Math.max(0.04, Math.min(0.4, 16 / up.size))})`;
  for (const [pair, weight] of up) {
    const [receiver, sender] = pair.split(' ').map(number => at.get(+number));
    if (weight && receiver && sender) { path(pen, [[receiver.x, receiver.y], [sender.x, sender.y]]); pen.stroke(); }
  }
}
function drawTrail(pen, robot, dashed) {
  const k = indexAt(now), end = poseAt(robot, now);
  pen.beginPath();
  let down = false;
  for (let i = 0; i <= k; i++) {
    if (isNaN(robot.x[i])) { down = false; continue; }
    if (down && !robot.breaks.has(i)) pen.lineTo(px(robot.x[i]), py(robot.y[i])); else pen.moveTo(px(robot.x[i]), py(robot.y[i]));
    down = true;
  }
  if (end && down) pen.lineTo(px(end.x), py(end.y));
  if (dashed) pen.setLineDash([1, 5]);
  if (robot.bright && !dashed) { pen.strokeStyle = '#404040'; pen.lineWidth = 3.2; pen.stroke(); }
  pen.strokeStyle = robot.colour; pen.lineWidth = 2; pen.stroke();
  pen.setLineDash([]);
}
function drawRobot(pen, robot, size, ghost) {
  const pose = poseAt(robot, now);
  if (!pose) return;
  const cos = Math.cos(pose.theta), sin = Math.sin(pose.theta);
  pen.beginPath();
  robot.outline.forEach(([a, b], k) => {
    const x = px(pose.x) + size * (a * cos - b * sin), y = py(pose.y) - size * (a * sin + b * cos);
    if (k) pen.lineTo(x, y); else pen.moveTo(x, y);
  });
  pen.closePath();
  pen.globalAlpha = ghost ? 0.35 : 1;
  pen.fillStyle = robot.colour; pen.fill();
  pen.strokeStyle = INK; pen.lineWidth = 1; pen.stroke();
  pen.globalAlpha = 1;
  if (ghost) return;
  const call = callAt(robot, now);
  pen.lineWidth = 2.5;
  if (call && call.kind && call.kind !== 'saturated') disc(pen, pose.x, pose.y, size * 1.7, null, KINDS[call.kind]);
  const sent = run.plane.sent[robot.number] || [], age = now - sent[countUntil(sent, now) - 1];
  if (age <= FLASH_S) disc(pen, pose.x, pose.y, size * (1.3 + 2 * age / FLASH_S), null, `rgba(230, 115, 0, ${1 - age / FLASH_S})`);
  pen.fillStyle = INK; pen.textAlign = 'left';
  if (run.robots.length <= MOST_NUMBERS) pen.fillText(robot.number, px(pose.x) + size + 2, py(pose.y) - size);
}
function drawSelected(pen, size) {
  const pose = selected && poseAt(selected, now), call = pose && callAt(selected, now);
  if (!pose) return;
  pen.lineWidth = 2;
  disc(pen, pose.x, pose.y, size * 2.1, null, INK);
  if (!call) return;
  pen.lineWidth = 1.3;
  for (const one of call.calls.known || []) {
    if (isNaN(one.x[call.place])) continue;
    const point = [one.x[call.place], one.y[call.place]];
    pen.strokeStyle = SOFT; pen.setLineDash([3, 3]);
    path(pen, [[pose.x, pose.y], point]); pen.stroke(); pen.setLineDash([]);
    disc(pen, ...point, size * 0.6, '#fff', (run.robots.find(robot => robot.number === one.number) || {colour: SOFT}).colour);
  }
  const reach = 1.5;  // the velocity as the way of so many seconds
  pen.strokeStyle = INK; pen.lineWidth = 2;
  path(pen, [[pose.x, pose.y], [pose.x + reach * call.vx, pose.y + reach * call.vy]]); pen.stroke();
}
function drawPlane() {
  const {pen, width, height} = sized(plane);
  scale = Math.min(width / frame.width, height / frame.height);
  originX = width / 2; originY = height / 2;
  const size = Math.max(5, 0.07 * scale, Math.min(width, height) * 0.016);
  drawGround(pen, width, height);
  drawDrawings(pen);
  if (find('links') && find('links').checked) drawLinks(pen);
  const ghosts = find('ghosts') && !find('ghosts').checked ? [] : run.others;
  const drawn = [...run.robots].reverse();  // those with colours of their own on top
  if (find('trails').checked) { ghosts.forEach(robot => drawTrail(pen, robot, true)); drawn.forEach(robot => drawTrail(pen, robot)); }
  ghosts.forEach(robot => drawRobot(pen, robot, size, true));
  drawn.forEach(robot => drawRobot(pen, robot, size));
  drawSelected(pen, size);
}

