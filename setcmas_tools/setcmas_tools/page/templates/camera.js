// The camera: which part of the plane is shown, and where on the canvas.

import {robots, run} from './history.js';

const MARGIN = 1.12, NEAREST = 60, STEP = 1.3;
const ROOM_M = {simulation: 7.5, experiment: 2.5};  // half the side of what a live page shows at least
const known = {left: Infinity, right: -Infinity, bottom: Infinity, top: -Infinity};
export const camera = {x: 0, y: 0, zoom: 1, scale: 1, width: 1, height: 1, moved: false, followed: null};

export function reach(x, y, radius = 0) {
  if (!isFinite(x) || !isFinite(y)) return;
  known.left = Math.min(known.left, x - radius); known.right = Math.max(known.right, x + radius);
  known.bottom = Math.min(known.bottom, y - radius); known.top = Math.max(known.top, y + radius);
}
function forgetReach() { Object.assign(known, {left: Infinity, right: -Infinity, bottom: Infinity, top: -Infinity}); }
export function reachAtLeast(isReal) {
  forgetReach();
  reach(0, 0, ROOM_M[isReal ? 'experiment' : 'simulation']);
}

export function reachRun() {
  forgetReach();
  for (const robot of robots) robot.x.forEach((x, k) => reach(x, robot.y[k]));
  for (const {points} of run.plane.references) points.forEach(([x, y]) => reach(x, y));
  for (const corners of run.plane.polygons) corners.forEach(([x, y]) => reach(x, y));
  for (const [x, y, radius] of run.plane.discs) reach(x, y, radius);
  if (run.plane.arena) { const [left, right, bottom, top] = run.plane.arena; reach(left, bottom); reach(right, top); }
}
if (run.live) reachAtLeast(false); else reachRun();

// Fit all that is known into the canvas, times the zoom; a robot that is followed is in the middle.
export function aim(width, height) {
  const empty = known.left > known.right;
  const spanX = empty ? 1 : Math.max(1, known.right - known.left), spanY = empty ? 1 : Math.max(1, known.top - known.bottom);
  Object.assign(camera, {width, height, scale: Math.min(width / spanX, height / spanY) / MARGIN * camera.zoom});
  const pose = camera.followed && camera.followed.pose;
  if (pose) Object.assign(camera, {x: pose.x, y: pose.y});
  else if (!camera.moved && !empty) Object.assign(camera, {x: (known.left + known.right) / 2, y: (known.bottom + known.top) / 2});
}
export const px = x => camera.width / 2 + (x - camera.x) * camera.scale;
export const py = y => camera.height / 2 - (y - camera.y) * camera.scale;

export function pan(dx, dy) {  // px
  camera.x -= dx / camera.scale; camera.y += dy / camera.scale;
  camera.moved = true;
}
// Zoom so that a place on the canvas stays where it is.
export function zoom(factor, atX = camera.width / 2, atY = camera.height / 2) {
  const before = camera.zoom;
  camera.zoom = Math.max(0.2, Math.min(NEAREST, before * factor));
  const ratio = camera.zoom / before - 1;
  camera.x += (atX - camera.width / 2) / camera.scale * ratio / (1 + ratio);
  camera.y -= (atY - camera.height / 2) / camera.scale * ratio / (1 + ratio);
  camera.scale *= 1 + ratio;
  camera.moved = true;
}
export const nearer = () => zoom(STEP), farther = () => zoom(1 / STEP);
export function showAll() { Object.assign(camera, {zoom: 1, moved: false}); }

// Fingers, mouse and wheel: one pans, two zoom; a click is none of them.
export function steer(canvas, changed) {
  const fingers = new Map();
  const spread = () => { const [a, b] = [...fingers.values()]; return Math.hypot(a.x - b.x, a.y - b.y); };
  canvas.addEventListener('pointerdown', event => fingers.set(event.pointerId, {x: event.offsetX, y: event.offsetY}));
  for (const kind of ['pointerup', 'pointercancel', 'pointerleave']) canvas.addEventListener(kind, event => fingers.delete(event.pointerId));
  canvas.addEventListener('pointermove', event => {
    const finger = fingers.get(event.pointerId);
    if (!finger || !event.buttons) return;
    const apart = fingers.size === 2 ? spread() : 0, {x, y} = finger;
    if (fingers.size === 1 && Math.hypot(event.offsetX - x, event.offsetY - y) < 4 && !finger.drags) return;
    Object.assign(finger, {x: event.offsetX, y: event.offsetY, drags: true});
    if (fingers.size === 2) zoom(spread() / apart, x, y); else pan(event.offsetX - x, event.offsetY - y);
    changed();
  });
  canvas.addEventListener('wheel', event => {
    if (!event.ctrlKey && document.activeElement !== canvas) return;  // the page scrolls
    event.preventDefault();
    zoom(Math.exp(-event.deltaY / 500), event.offsetX, event.offsetY);
    changed();
  }, {passive: false});
}
