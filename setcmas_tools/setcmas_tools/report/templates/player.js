// The player: charts and numbers at the time of one bar, and what moves it.
const bar = find('bar');
let playing = false, before = 0;

// A chart for each curve, with the time of the bar as a line in it.
const charts = run.charts.map(chart => {
  const box = document.createElement('figure'), caption = document.createElement('figcaption');
  const canvas = document.createElement('canvas');
  box.append(caption, canvas);
  find('charts').append(box);
  const all = [chart.values, chart.other || {}].flatMap(values => Object.values(values)).flat().filter(isFinite);
  const low = all.reduce((a, b) => Math.min(a, b), 0), high = all.reduce((a, b) => Math.max(a, b), low + 1e-3);
  canvas.addEventListener('pointerdown', event => canvas.setPointerCapture(event.pointerId));
  for (const kind of ['pointerdown', 'pointermove']) canvas.addEventListener(kind, event => {
    if (event.buttons) show(first + (event.offsetX - 40) / (canvas.clientWidth - 48) * (last - first));
  });
  return {...chart, caption, canvas, low, high};
});
function drawChart(chart) {
  const {pen, width, height} = sized(chart.canvas), k = indexAt(now);
  const x = t => 40 + (t - first) / Math.max(KEPT, last - first) * (width - 48);
  const y = value => height - 18 - (value - chart.low) / (chart.high - chart.low) * (height - 24);
  const gap = roundStep(chart.high - chart.low, 4), digits = Math.max(0, -Math.floor(Math.log10(gap) + KEPT));
  pen.lineWidth = 1; pen.strokeStyle = LINE; pen.fillStyle = SOFT; pen.textAlign = 'right';
  for (let n = Math.ceil(chart.low / gap); n * gap <= chart.high; n++) {
    pen.beginPath(); pen.moveTo(40, y(n * gap)); pen.lineTo(width - 8, y(n * gap)); pen.stroke();
    pen.fillText((n * gap).toFixed(digits), 35, y(n * gap) + 4);
  }
  pen.textAlign = 'center';
  const pause = roundStep(Math.max(KEPT, last - first), width / 70);
  for (let n = Math.ceil(first / pause); n * pause <= last; n++) pen.fillText(+(n * pause).toFixed(6), Math.min(x(n * pause), width - 12), height - 3);
  for (const [values, dashes] of [[chart.other || {}, [4, 3]], [chart.values, []]]) {
    pen.setLineDash(dashes);
    for (const number in values) {
      const robot = run.robots.find(one => one.number === +number), look = robot || {colour: INK};
      pen.beginPath();
      let down = false;
      values[number].forEach((value, i) => {
        if (!isNaN(value)) { if (down) pen.lineTo(x(times[i]), y(value)); else pen.moveTo(x(times[i]), y(value)); }
        down = !isNaN(value);
      });
      if (look.bright) { pen.lineWidth = 2.6; pen.strokeStyle = '#404040'; pen.stroke(); }
      pen.lineWidth = selected && selected === robot ? 3 : 1.5; pen.strokeStyle = look.colour; pen.stroke();
    }
  }
  pen.setLineDash([]); pen.lineWidth = 1.5; pen.strokeStyle = KINDS.failed;
  pen.beginPath(); pen.moveTo(x(now), 2); pen.lineTo(x(now), height - 16); pen.stroke();
  const own = chart.values[0] || (selected && chart.values[selected.number]);
  chart.caption.textContent = chart.name + (own ? ` ${number(own[k], 3)} ${chart.unit}` : ` (${chart.unit})`);
}

// Numbers of the robots, and all that is known of the selected one.
const number = (value, digits) => isNaN(value) ? '–' : value.toFixed(digits).replace(/^-(0\.?0*)$/, '$1').replace('-', '−');
const wrapped = angle => Math.atan2(Math.sin(angle), Math.cos(angle));
const rows = run.robots.map(robot => {
  const row = find('robots').insertRow(), head = document.createElement('th'), button = document.createElement('button');
  button.textContent = robot.name;
  button.style.setProperty('--colour', robot.colour);
  button.addEventListener('click', () => select(robot));
  head.append(button);
  row.append(head);
  for (let k = 0; k < 5; k++) row.insertCell();
  return row;
});
function fillRows() {
  run.robots.forEach((robot, n) => {
    const pose = poseAt(robot, now) || {x: NaN, y: NaN, theta: NaN, v: NaN}, call = callAt(robot, now);
    const texts = [number(pose.x, 3), number(pose.y, 3), number(wrapped(pose.theta), 2), number(pose.v, 3), call ? call.kind : ''];
    texts.forEach((text, k) => { rows[n].cells[k + 1].textContent = text; });
    rows[n].className = (robot === selected ? 'selected ' : '') + (call ? call.kind : '');
  });
}
function line(...parts) {
  const row = find('about').appendChild(document.createElement('p'));
  row.textContent = parts.join('');
  return row;
}
function fillAbout() {
  find('about').replaceChildren();
  if (!selected) { line('Click a robot: what its law wanted and knew, and what became of it.'); return; }
  const pose = poseAt(selected, now), call = callAt(selected, now);
  line(selected.name).className = 'name';
  if (pose) line(`at (${number(pose.x, 3)}, ${number(pose.y, 3)}) m, heading ${number(wrapped(pose.theta), 3)} rad, `,
    `speed ${number(pose.v, 3)} m/s, turn rate ${number(pose.omega, 3)} rad/s`);
  else line('is not known now');
  if (!call) { line('No call of its law is recorded until now.'); return; }
  const {calls, place} = call;
  if (call.kind !== 'failed') line(`Its law, called at t = ${number(call.t, 2)} s, wanted (${number(call.vx, 3)}, ${number(call.vy, 3)}) m/s, `,
    `a speed of ${number(Math.hypot(call.vx, call.vy), 3)} m/s.`);
  if (calls.allowedX) line(`The safety filter let through (${number(calls.allowedX[place], 3)}, ${number(calls.allowedY[place], 3)}) m/s.`);
  if (call.words) line(call.words).className = call.kind;
  if (calls.unknown) line('What it knew of the others: ', calls.unknown, '.');
  else if (!calls.known) line('It knew where all others were at that call.');
  else {
    line('It knew of the others:');
    for (const one of calls.known) line(`${one.name} at `, isNaN(one.x[place]) ? 'an unknown place' : `(${number(one.x[place], 3)}, ${number(one.y[place], 3)}) m`).className = 'known';
  }
}

// The time, and what moves it.
function show(t) {
  now = Math.max(first, Math.min(last, t));
  bar.value = now;
  find('now').textContent = `t = ${number(now, step < 0.1 ? 2 : 1)} s`;
  drawPlane();
  charts.forEach(drawChart);
  fillRows();
  fillAbout();
}
const snapped = t => times[Math.max(0, Math.min(times.length - 1, Math.round((t - first) / step)))];
function play(on) {
  playing = on;
  find('play').textContent = on ? '❚❚' : '▶';
  find('play').setAttribute('aria-label', on ? 'pause' : 'play');
  if (!on) { show(snapped(now)); return; }
  if (now >= last) now = first;
  before = performance.now();
  requestAnimationFrame(advance);
}
function advance(clock) {
  if (!playing) return;
  show(now + Math.max(0, clock - before) / 1000 * find('speed').value);
  before = clock;
  if (now >= last) play(false); else requestAnimationFrame(advance);
}
function select(robot) {
  selected = selected === robot ? null : robot;
  show(now);
}
function move(t) { now = t; play(false); }
function faster(by) { const speed = find('speed'); speed.selectedIndex = Math.max(0, Math.min(speed.length - 1, speed.selectedIndex + by)); }
const KEYS = {
  ' ': () => play(!playing), ArrowRight: () => move(now + step), ArrowLeft: () => move(now - step),
  Home: () => move(first), End: () => move(last), '+': () => faster(1), '-': () => faster(-1),
};
document.addEventListener('keydown', event => {
  if (!KEYS[event.key] || event.ctrlKey || event.altKey || event.metaKey || event.target.tagName === 'SELECT') return;
  event.preventDefault();
  KEYS[event.key]();
});
bar.min = first; bar.max = last; bar.step = step;
bar.addEventListener('input', () => move(+bar.value));
find('play').addEventListener('click', () => play(!playing));
find('back').addEventListener('click', () => move(now - step));
find('forth').addEventListener('click', () => move(now + step));
plane.addEventListener('click', event => {
  const near = run.robots.map(robot => [robot, poseAt(robot, now)]).filter(([, pose]) => pose)
    .map(([robot, pose]) => [robot, Math.hypot(px(pose.x) - event.offsetX, py(pose.y) - event.offsetY)]).sort((a, b) => a[1] - b[1])[0];
  if (near && near[1] < 24) select(near[0]);
});
for (const box of document.querySelectorAll('#shown input')) box.addEventListener('change', () => show(now));
for (const link of document.querySelectorAll('[data-t]')) link.addEventListener('click', () => {
  selected = run.robots.find(robot => robot.number === +link.dataset.robot) || selected;
  move(+link.dataset.t);
  find('replay').scrollIntoView();
});
function follow() {
  const asked = /^#t=(-?[\d.]+)$/.exec(location.hash);
  move(asked ? +asked[1] : first);
}
window.addEventListener('hashchange', follow);
window.addEventListener('resize', () => show(now));
window.addEventListener('beforeprint', () => show(now));
follow();
