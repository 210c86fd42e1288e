// The page: its elements, keys and address, and what each of them does.

import {camera, farther, nearer, pan, showAll, steer} from './camera.js';
import {find} from './canvas.js';
import {addCharts} from './charts.js';
import {byNumber, first, isLive, last, linksAt, robots, run, shapes, times} from './history.js';
import {addCommands, connect} from './live.js';
import {robotAt} from './plane.js';
import {back, faster, forth, move, player, redraw, select, start, toBegin, toEnd, toPresent, toggle} from './player.js';

const PAN_PX = 40;
const KEYS = {
  ' ': toggle, ArrowRight: forth, ArrowLeft: back, Home: toBegin, End: toEnd, '+': () => faster(1), '=': () => faster(1), '-': () => faster(-1),
  z: () => then(nearer), Z: () => then(farther), 0: () => then(showAll),
};
const SHIFTED = {ArrowLeft: [PAN_PX, 0], ArrowRight: [-PAN_PX, 0], ArrowUp: [0, PAN_PX], ArrowDown: [0, -PAN_PX]};
const TYPING = 'select, textarea, [contenteditable=true], input:not([type=range], [type=checkbox])';
function then(change) { change(); redraw(); }

document.addEventListener('keydown', event => {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest(TYPING)) return;
  if (event.key === ' ' && event.target.matches('button, input[type=checkbox], summary')) return;  // it presses that
  const shifted = event.shiftKey && SHIFTED[event.key], does = shifted ? () => then(() => pan(...shifted)) : KEYS[event.key];
  if (!does) return;
  event.preventDefault();
  does();
});
const CLICKS = {
  play: toggle, back, forth, latest: toPresent,
  nearer: () => then(nearer), farther: () => then(farther), whole: () => then(showAll),
};
for (const [id, does] of Object.entries(CLICKS)) find(id).addEventListener('click', does);
find('bar').addEventListener('input', () => move(+find('bar').value));
find('plane').addEventListener('click', event => {
  const robot = robotAt(event.offsetX, event.offsetY);
  if (robot) select(robot);
});
steer(find('plane'), redraw);
for (const choice of document.querySelectorAll('#shown input, #shown select')) choice.addEventListener('change', () => {
  camera.followed = find('follow').checked ? player.selected : null;
  redraw();
});
for (const link of document.querySelectorAll('[data-t]')) link.addEventListener('click', () => {
  player.selected = byNumber.get(+link.dataset.robot) || player.selected;
  move(+link.dataset.t);
  find('replay').scrollIntoView();
});
function followAddress() {
  const asked = /^#t=(-?[\d.]+)$/.exec(location.hash);
  move(asked ? +asked[1] : first());
}
window.addEventListener('resize', redraw);
// Paper shows the end of a run that is at its beginning, where there are no trails yet.
let shownBefore = null;
window.addEventListener('beforeprint', () => {
  document.body.classList.add('printing');
  if (!isLive && player.now <= first()) { shownBefore = player.now; player.now = last(); }
  redraw();
});
window.addEventListener('afterprint', () => {
  document.body.classList.remove('printing');
  if (shownBefore !== null) { player.now = shownBefore; shownBefore = null; }
  redraw();
});

window.page = {camera, linksAt, player, shapes, get robots() { return robots; }, get times() { return times; }};  // for the console

addCharts(move);
if (isLive) {
  run.clock = [];
  connect();
  if (run.live.commands) addCommands();
} else {
  window.addEventListener('hashchange', followAddress);
  followAddress();
}
start();
