// The player: the time that is shown, and everything that changes it.

import {camera, reachRun, showAll} from './camera.js';
import {find, number} from './canvas.js';
import {addCharts, drawChart} from './charts.js';
import {first, indexAt, isLive, last, openRun, run, times} from './history.js';
import {drawPlane} from './plane.js';
import {fillAbout, fillRows} from './robots.js';

const PICTURE_MS = 1000 / 35, FIGURES_MS = 200, DELAY_S = 0.15;
export const player = {now: 0, playing: false, atPresent: isLive, selected: null, offset: -Infinity, pictures: 0};
const step = () => !isLive && times.length > 1 ? times[1] - times[0] : 0.1;
let before = 0, pictured = 0, figured = 0;

export function show(t, clock = Infinity) {  // without a clock everything is drawn again
  player.now = Math.max(first(), Math.min(last(), t));
  drawPlane(player.now, player.selected, clock < Infinity);
  player.pictures++;
  if (clock - figured < FIGURES_MS) return;
  figured = performance.now();
  const bar = find('bar');
  bar.min = first(); bar.max = last(); bar.step = step(); bar.value = player.now;
  find('now').textContent = timeText();
  bar.setAttribute('aria-valuetext', find('now').textContent);
  find('latest').hidden = !isLive || player.atPresent;
  run.charts.forEach(chart => drawChart(chart, player.now, player.selected));
  fillRows(player.now, player.selected, select, clock < Infinity);
  fillAbout(player.now, player.selected);
}
function timeText() {
  const digits = step() < 0.1 ? 2 : 1;
  if (!isLive) return `t = ${number(player.now, digits)} s`;
  const t = run.clock[indexAt(player.now)], ago = last() - player.now;
  return `t = ${number(t ?? NaN, 1)} s` + (player.atPresent ? '' : `, ${number(ago, 1)} s ago`);
}
export const redraw = () => show(player.now);

// The time of the newest message on the clock of this browser; the message with the least delay sets it.
export function meet(t) {
  const offset = t - performance.now() / 1000;
  player.offset = Math.max(offset, player.offset - 1e-3);
  if (Math.abs(offset - player.offset) > 2) player.offset = offset;  // this computer has slept
}
function advance(clock) {
  requestAnimationFrame(advance);
  if (clock - pictured < PICTURE_MS) return;
  pictured = clock;
  if (player.atPresent) show(clock / 1000 + player.offset - DELAY_S, clock);
  else if (player.playing) {
    show(player.now + Math.max(0, clock - before) / 1000 * find('speed').value, clock);
    if (player.now >= last() - (isLive ? DELAY_S : 0)) { if (isLive) toPresent(); else play(false); }
  }
  before = clock;
}
function showWhetherPlaying(on) {
  find('play').textContent = on ? '❚❚' : '▶';
  find('play').setAttribute('aria-label', on ? 'hold the picture' : 'play');
}
export function play(on) {
  player.playing = on;
  if (player.atPresent) player.atPresent = false;
  showWhetherPlaying(on);
  if (on && player.now >= last()) player.now = first();
  before = performance.now();
  if (!on) show(snapped(player.now));
}
const snapped = t => isLive || !times.length ? t : times[Math.max(0, Math.min(times.length - 1, Math.round((t - first()) / step())))];
export function move(t) { player.now = t; play(false); }
export function toPresent() { player.playing = false; player.atPresent = true; showWhetherPlaying(true); redraw(); }
export function toggle() { play(player.atPresent ? false : !player.playing); }
export const forth = () => move(player.now + step()), back = () => move(player.now - step());
export const toBegin = () => move(first());
export const toEnd = () => isLive ? toPresent() : move(last());
export function faster(by) {
  const speed = find('speed');
  speed.selectedIndex = Math.max(0, Math.min(speed.length - 1, speed.selectedIndex + by));
}
export function select(robot) {
  player.selected = player.selected === robot ? null : robot;
  camera.followed = find('follow').checked ? player.selected : null;
  redraw();
}
// Show another finished run, whose content is changed in place, at its beginning.
export function open(content) {
  openRun(content);
  find('links').parentElement.hidden = !run.plane.links;
  reachRun();
  showAll();
  player.selected = camera.followed = null;
  addCharts(move);
  move(first());
}
export function start() {
  find('links').parentElement.hidden = !isLive && !run.plane.links;
  showWhetherPlaying(isLive);
  requestAnimationFrame(advance);
}
