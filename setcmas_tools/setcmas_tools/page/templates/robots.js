// The table of the robots, and details of the selected one.

import {find, number} from './canvas.js';
import {callAt, isLive, poseAt, robots, stateAt, wrapped} from './history.js';

const rows = new Map();
const UNKNOWN = {x: NaN, y: NaN, theta: NaN, v: NaN};

function addRow(robot, select) {
  const row = document.createElement('tr'), head = document.createElement('th'), button = document.createElement('button');
  head.scope = 'row';
  button.textContent = robot.name;
  button.style.setProperty('--colour', robot.colour);
  button.addEventListener('click', () => select(robot));
  head.append(button);
  row.append(head);
  for (let k = 0; k < 5; k++) row.insertCell();
  return {row, button, texts: []};
}

// As many rows as robots, in their order.
function matchRows(select) {
  for (const [robot, {row}] of rows) if (!robots.includes(robot)) { row.remove(); rows.delete(robot); }
  if (rows.size === robots.length) return;
  for (const robot of robots) {
    if (!rows.has(robot)) rows.set(robot, addRow(robot, select));
    find('robots').append(rows.get(robot).row);
  }
}
export function fillRows(now, selected, select, often) {
  matchRows(select);
  const {scrollTop, clientHeight} = find('robots').closest('.rows');
  const height = rows.size ? find('robots').offsetHeight / rows.size : 1, top = scrollTop / height - 2, bottom = top + clientHeight / height + 3;
  for (const [place, robot] of robots.entries()) {
    if (often && (place < top || place > bottom)) continue;  // not in sight
    const {row, button, texts} = rows.get(robot);
    const pose = poseAt(robot, now) || UNKNOWN, {kind, label} = stateAt(robot, now);
    const fresh = [number(pose.x, 3), number(pose.y, 3), number(wrapped(pose.theta), 2), number(pose.v, 3), label];
    fresh.forEach((text, k) => { if (text !== texts[k]) row.cells[k + 1].textContent = texts[k] = text; });
    const look = (robot === selected ? 'selected ' : '') + kind;
    if (row.className !== look) { row.className = look; button.setAttribute('aria-pressed', robot === selected); }
  }
}

function line(...parts) {
  const row = find('about').appendChild(document.createElement('p'));
  row.textContent = parts.join('');
  return row;
}
export function fillAbout(now, selected) {
  find('about').replaceChildren();
  if (!selected) { line(`Select a robot, here or in the picture, to see ${isLive ? 'its pose and speeds' : 'the velocity that its law returned'}.`); return; }
  const pose = poseAt(selected, now), call = callAt(selected, now), {kind, words} = stateAt(selected, now);
  line(selected.name).className = 'name';
  if (pose) line(`at (${number(pose.x, 3)}, ${number(pose.y, 3)}) m, heading ${number(wrapped(pose.theta), 3)} rad, speed ${number(pose.v, 3)} m/s`,
    isNaN(pose.omega) ? '' : `, turn rate ${number(pose.omega, 3)} rad/s`);
  else line('Its pose is unknown at this time.');
  if (call) aboutCall(call); else if (!words && !isLive) line('No call of its law is recorded before this time.');
  if (words) line(words).className = kind;
}
function aboutCall({calls, place, kind, t, vx, vy}) {
  if (kind !== 'failed') line(`Its law, called at t = ${number(t, 2)} s, returned (${number(vx, 3)}, ${number(vy, 3)}) m/s, `,
    `a speed of ${number(Math.hypot(vx, vy), 3)} m/s.`);
  if (calls.allowedX) line(`The safety filter allowed (${number(calls.allowedX[place], 3)}, ${number(calls.allowedY[place], 3)}) m/s.`);
}
