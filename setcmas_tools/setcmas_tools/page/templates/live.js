// A live run: messages from the server, and requests of the buttons.

import {reach, reachAtLeast} from './camera.js';
import {find} from './canvas.js';
import {addFrame, addLink, addRobot, addSent, addShape, addState, byNumber, forgetAll, run} from './history.js';
import {meet, player, redraw, toPresent} from './player.js';

const AGAIN_MS = 1000;
let socket = null, status = {};

// What each kind of message does; all have a time in s, of which the newest picture is a little behind.
const TAKES = {
  begin: () => { forgetAll(); reachAtLeast(status.real); player.selected = null; toPresent(); },
  looks: ({items}) => items.forEach(([number, look]) => {
    const robot = byNumber.get(number);
    if (robot) Object.assign(robot, look); else addRobot(look);
  }),
  frame: message => {
    addFrame(message);
    for (let k = 0; k < message.poses.length; k += 4) reach(message.poses[k], message.poses[k + 1]);
  },
  states: ({t, items}) => items.forEach(([number, [kind, label, words]]) => addState(number, {t, kind, label, words})),
  sent: ({t, numbers}) => numbers.forEach(number => addSent(number, t)),
  links: ({t, items}) => items.forEach(([pair, weight]) => addLink(t, ...pair.split(' ').map(Number), weight)),
  shapes: ({t, items}) => items.forEach(([key, shape]) => {
    addShape(key, t, shape);
    if (shape && shape.kind === 'lines') shape.places.forEach(([a, b, c, d]) => { reach(a, b); reach(c, d); });
  }),
  now: ({t}) => meet(t),
  status: message => {
    if (message.real !== status.real) reachAtLeast(message.real);
    status = message;
    showStatus();
  },
};

function write(id, text) { if (find(id).textContent !== text) find(id).textContent = text; }
function showStatus() {
  const {title, detail, state, paused, stopped, real, ended} = status;
  write('title', title); write('detail', detail); write('state', state);
  document.title = title;
  find('state').className = 'outcome ' + (stopped ? 'bad' : paused ? 'some' : 'good');
  if (!run.live.commands) return;
  find('stop').hidden = !real; find('stop').disabled = stopped;
  find('stop').textContent = stopped ? 'STOPPED: press R twice in the terminal' : 'STOP';
  find('pause').hidden = ended; find('pause').textContent = paused && !real ? 'Start' : 'Pause';
  find('pause').disabled = real && paused;
  find('reset').hidden = real || ended;
}
function press(button) {
  if (socket && socket.readyState === WebSocket.OPEN) socket.send(button);
}

export function connect() {
  socket = new WebSocket(`${location.protocol.replace('http', 'ws')}//${location.host}/live${location.search}`);
  socket.addEventListener('message', ({data}) => JSON.parse(data).forEach(message => TAKES[message.kind](message)));
  socket.addEventListener('close', () => {
    write('state', 'no connection to setcmas view; trying again');
    find('state').className = 'outcome bad';
    setTimeout(connect, AGAIN_MS);
  });
}
export function addCommands() {
  find('stop').addEventListener('click', () => press('stop'));
  find('pause').addEventListener('click', () => press(status.real || !status.paused ? 'pause' : 'start'));
  find('reset').addEventListener('click', () => { press('reset'); redraw(); });
}
