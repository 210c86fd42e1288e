// The plane at a time: ground, drawings, links, trails, robots.

import {aim, camera, px, py} from './camera.js';
import {EDGE, INK, KINDS, LINE, SOFT, digitsOf, find, number, roundStep, sized} from './canvas.js';
import {TINY, byNumber, callAt, endedShapes, first, indexAt, lastSent, linksAt, poseAt, robots, run, shapes, shapesUntil, stateAt} from './history.js';

const FLASH_S = 0.5, MOST_NUMBERS = 20, MOST_TRAIL_POINTS = 25_000, ARROW_S = 1.5, GROUND_MS = 200, TAILS_MS = 1000;
const OBSTACLE = '#d0d7de', BORDER = '#8c959f';

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

function drawGrid(pen, width, height) {
  const gap = roundStep(Math.max(width, height) / camera.scale, Math.max(4, Math.max(width, height) / 70)), digits = digitsOf(gap);
  const halfX = width / 2 / camera.scale, halfY = height / 2 / camera.scale;
  pen.lineWidth = 1; pen.strokeStyle = LINE; pen.fillStyle = SOFT;
  pen.textAlign = 'center';
  for (let k = Math.ceil((camera.x - halfX) / gap); k * gap < camera.x + halfX; k++) {
    const x = px(k * gap);
    pen.beginPath(); pen.moveTo(x, 0); pen.lineTo(x, height); pen.stroke();
    if (x > 40 && x < width - 60) pen.fillText(number(k * gap, digits), x, height - 5);
  }
  pen.textAlign = 'left';
  for (let k = Math.ceil((camera.y - halfY) / gap); k * gap < camera.y + halfY; k++) {
    const y = py(k * gap);
    pen.beginPath(); pen.moveTo(0, y); pen.lineTo(width, y); pen.stroke();
    if (y > 32 && y < height - 24) pen.fillText(number(k * gap, digits), 4, y - 3);
  }
  pen.textAlign = 'right'; pen.fillText('x (m)', width - 4, height - 5);
  pen.textAlign = 'left'; pen.fillText('y (m)', 4, 12);
}
function drawWorld(pen) {
  const {arena, discs, polygons, references} = run.plane;
  pen.lineWidth = 1.5; pen.strokeStyle = BORDER; pen.fillStyle = OBSTACLE;
  if (arena) { const [a, b, c, d] = arena; path(pen, [[a, c], [b, c], [b, d], [a, d]], true); pen.stroke(); }
  for (const corners of polygons) { path(pen, corners, true); pen.fill(); pen.stroke(); }
  for (const [x, y, radius] of discs) disc(pen, x, y, radius * camera.scale, OBSTACLE, BORDER);
  for (const one of references) {
    pen.strokeStyle = one.colour; pen.lineWidth = 1.3;
    if (one.joined) { pen.setLineDash([2, 4]); path(pen, one.points); pen.stroke(); pen.setLineDash([]); }
    if (one.marked) for (const [x, y] of one.points) pen.strokeRect(px(x) - 4, py(y) - 4, 8, 8);
  }
}

// Shapes: each draws one place of a shape, with its size.
const SHAPES = {
  discs: (pen, [x, y], colour, size) => disc(pen, x, y, Math.max(2, size / 2 * camera.scale), colour),
  lines: (pen, [x, y, toX, toY], colour, size) => {
    pen.strokeStyle = colour; pen.lineWidth = Math.max(1.2, size * camera.scale);
    path(pen, [[x, y], [toX, toY]]); pen.stroke();
  },
};
// Shapes that stay where they are belong to the ground, which shows those that began before already.
function drawShapes(pen, now, still, since = -Infinity) {
  for (let k = shapesUntil(since); k < shapes.length; k++) {
    const shape = shapes[k];
    if (shape.from > now + TINY) break;
    if (shape.to <= now + TINY || shape.moves === still) continue;
    pen.globalAlpha = shape.alpha;
    for (const place of shape.places) SHAPES[shape.kind](pen, place, shape.colour, shape.size);
  }
  pen.globalAlpha = 1;
}

function drawLinks(pen, now) {
  const pairs = linksAt(now), shade = Math.max(0.04, Math.min(0.4, 16 / pairs.size));
  pen.lineWidth = 1; pen.strokeStyle = `rgba(87, 96, 106, ${shade})`;
  pen.beginPath();
  for (const [i, j] of pairs.values()) {
    const receiver = byNumber.get(i)?.pose, sender = byNumber.get(j)?.pose;
    if (!receiver || !sender) continue;
    pen.moveTo(px(receiver.x), py(receiver.y)); pen.lineTo(px(sender.x), py(sender.y));
  }
  pen.stroke();
}
function drawTrail(pen, robot, from, now) {
  const end = indexAt(now), begin = indexAt(from);
  const each = Math.max(1, Math.ceil((end - begin) * robots.length / MOST_TRAIL_POINTS));
  let leg = null;
  pen.beginPath();
  for (let k = Math.ceil(begin / each) * each; k <= end; k += each) {
    if (isNaN(robot.x[k])) { leg = null; continue; }
    if (robot.leg[k] === leg) pen.lineTo(px(robot.x[k]), py(robot.y[k])); else pen.moveTo(px(robot.x[k]), py(robot.y[k]));
    leg = robot.leg[k];
  }
  if (robot.pose && leg === robot.leg[end]) pen.lineTo(px(robot.pose.x), py(robot.pose.y));
  if (robot.bright) { pen.strokeStyle = EDGE; pen.lineWidth = 3.2; pen.lineCap = 'butt'; pen.stroke(); pen.lineCap = 'round'; }
  pen.strokeStyle = robot.colour; pen.lineWidth = 2; pen.stroke();
}
const drawTrails = (pen, from, now) => drawn().forEach(robot => drawTrail(pen, robot, from, now));
function drawStarts(pen) {
  for (const {x, y, colour} of robots) {
    const k = x.findIndex(value => !isNaN(value));
    if (k < 0) continue;
    pen.lineWidth = 1.5;
    disc(pen, x[k], y[k], 4.5, '#fff', colour);
  }
}
// Robots of a colour in one path: fewer calls than one for each robot.
function drawRobots(pen, shown, times) {
  const paths = new Map();
  for (const {pose, outline, colour, metres} of shown) {
    if (!pose) continue;
    if (!paths.has(colour)) paths.set(colour, new Path2D());
    const path = paths.get(colour), size = halfOf(metres, times), cos = size * Math.cos(pose.theta), sin = size * Math.sin(pose.theta);
    const x = px(pose.x), y = py(pose.y);
    outline.forEach(([a, b], k) => k ? path.lineTo(x + a * cos - b * sin, y - a * sin - b * cos) : path.moveTo(x + a * cos - b * sin, y - a * sin - b * cos));
    path.closePath();
  }
  pen.strokeStyle = INK; pen.lineWidth = 1;
  for (const [colour, path] of paths) { pen.fillStyle = colour; pen.fill(path, 'nonzero'); pen.stroke(path); }
}
function drawSigns(pen, robot, size, now) {
  const {pose} = robot;
  if (!pose) return;
  const {kind} = stateAt(robot, now), age = now - lastSent(robot, now);
  pen.lineWidth = 2.5;
  if (kind && kind !== 'saturated') disc(pen, pose.x, pose.y, size * 1.7, null, KINDS[kind]);
  if (age <= FLASH_S) disc(pen, pose.x, pose.y, size * (1.3 + 2 * age / FLASH_S), null, `rgba(230, 115, 0, ${1 - age / FLASH_S})`);
  pen.fillStyle = INK; pen.textAlign = 'left';
  if (robots.length <= MOST_NUMBERS) pen.fillText(robot.number, px(pose.x) + size + 2, py(pose.y) - size);
}
function drawSelected(pen, robot, size, now) {
  const pose = robot && robot.pose, call = pose && callAt(robot, now);
  if (!pose) return;
  pen.lineWidth = 2;
  disc(pen, pose.x, pose.y, size * 2.1, null, INK);
  if (!call) return;
  pen.strokeStyle = INK; pen.lineWidth = 2;  // its velocity as the way of so many seconds
  path(pen, [[pose.x, pose.y], [pose.x + ARROW_S * call.vx, pose.y + ARROW_S * call.vy]]); pen.stroke();
}

// Half the side of a robot's symbol in px: one that can be seen, or as many times its true size as chosen.
const halfOf = (metres, times) => times ? times * metres * camera.scale : Math.max(5, 0.07 * camera.scale, Math.min(camera.width, camera.height) * 0.016);
const drawn = () => [...robots].reverse();  // those with colours of their own on top

// Grid, trails and what stays in its place are on a canvas of their own, to which a few times a second is added what is new;
// on paper, they are on that of the robots: Chromium prints one of two canvases.
const ground = {look: '', t: Infinity, at: 0, wholeAt: 0, ended: 0, pen: null};
const isPrinting = () => document.body.classList.contains('printing');
function drawGround(now, length, often, plane) {
  const {x, y, scale, width, height} = camera, clock = performance.now();
  const look = [x, y, scale, width, height, length, first()].join(), since = ground.t;
  const isSame = often && look === ground.look && now >= since;
  if (isSame && clock - ground.at < GROUND_MS) return;
  const onlyGrows = (length === Infinity || !length) && ground.ended === endedShapes();
  const adds = isSame && (onlyGrows || clock - ground.wholeAt < TAILS_MS);
  Object.assign(ground, {look, t: now, at: clock});
  if (!adds) {
    Object.assign(ground, {pen: isPrinting() ? plane : sized(find('ground')).pen, wholeAt: clock, ended: endedShapes()});
    drawGrid(ground.pen, width, height);
    drawWorld(ground.pen);
  }
  if (length) drawTrails(ground.pen, adds ? since : now - length, now);
  if (isPrinting()) drawStarts(ground.pen);
  drawShapes(ground.pen, now, true, adds ? since : -Infinity);
}

export function drawPlane(now, selected, often) {
  const {pen, width, height} = sized(find('plane')), place = indexAt(now);
  for (const robot of robots) robot.pose = poseAt(robot, now, place);
  aim(width, height);
  const times = +find('size').value, length = +find('trails').value;
  drawGround(now, length, often, pen);
  if (length && ground.t < now) drawTrails(pen, ground.t, now);
  if (ground.t < now) drawShapes(pen, now, true, ground.t);
  drawShapes(pen, now, false);
  if (run.plane.links && find('links').checked) drawLinks(pen, now);
  drawRobots(pen, drawn(), times);
  robots.forEach(robot => drawSigns(pen, robot, halfOf(robot.metres, times), now));
  drawSelected(pen, selected, selected && halfOf(selected.metres, times), now);
}

// The robot that is drawn nearest to a place on the canvas; null if none is near.
export function robotAt(x, y) {
  const near = robots.filter(robot => robot.pose)
    .map(robot => [robot, Math.hypot(px(robot.pose.x) - x, py(robot.pose.y) - y)]).sort((a, b) => a[1] - b[1])[0];
  return near && near[1] < 24 ? near[0] : null;
}
