// Charts of quantities over time, with the shown time as a line in each.

import {EDGE, INK, KINDS, LINE, SOFT, digitsOf, find, number, roundStep, sized} from './canvas.js';
import {TINY, byNumber, countUntil, first, indexAt, isLive, last, run, times} from './history.js';

const LEFT = 40, RIGHT = 8, LONGEST_S = 60;  // px; what the charts of a live page show
const begin = () => isLive ? Math.max(first(), last() - LONGEST_S) : first();

export function addCharts(seek) {
  find('charts').replaceChildren();
  for (const chart of run.charts) {
    const box = document.createElement('figure');
    chart.caption = document.createElement('figcaption');
    chart.canvas = document.createElement('canvas');
    box.append(chart.caption, chart.canvas);
    find('charts').append(box);
    const {canvas} = chart;
    canvas.addEventListener('pointerdown', event => canvas.setPointerCapture(event.pointerId));
    for (const kind of ['pointerdown', 'pointermove']) canvas.addEventListener(kind, event => {
      if (event.buttons) seek(begin() + (event.offsetX - LEFT) / (canvas.clientWidth - LEFT - RIGHT) * (last() - begin()));
    });
  }
}

// The least and the greatest value from a place on; 0 is among them.
function rangeOf(chart, from) {
  if (chart.range) return chart.range;
  let low = 0, high = 1e-3;
  for (const one of Object.values(chart.values))
    for (let k = from; k < one.length; k++) { if (one[k] < low) low = one[k]; if (one[k] > high) high = one[k]; }
  if (!isLive) chart.range = [low, high];
  return [low, high];
}

export function drawChart(chart, now, selected) {
  chart.canvas.parentNode.hidden = isLive && !Number.isFinite((chart.values[0] || []).at(-1));
  if (chart.canvas.parentNode.hidden) return;
  const {pen, width, height} = sized(chart.canvas), from = begin(), start = Math.max(0, countUntil(times, from) - 1);
  const [low, high] = rangeOf(chart, start), span = Math.max(TINY, last() - from);
  const x = t => LEFT + (t - from) / span * (width - LEFT - RIGHT);
  const y = value => height - 18 - (value - low) / (high - low) * (height - 24);
  const gap = roundStep(high - low, 4), pause = roundStep(span, width / 70);
  pen.lineWidth = 1; pen.strokeStyle = LINE; pen.fillStyle = SOFT; pen.textAlign = 'right';
  for (let n = Math.ceil(low / gap); n * gap <= high; n++) {
    pen.beginPath(); pen.moveTo(LEFT, y(n * gap)); pen.lineTo(width - RIGHT, y(n * gap)); pen.stroke();
    pen.fillText(number(n * gap, digitsOf(gap)), LEFT - 5, y(n * gap) + 4);
  }
  pen.textAlign = 'center';
  const shift = isLive ? (run.clock.at(-1) || 0) - last() : 0;  // ticks in the run's own time
  for (let n = Math.ceil((from + shift) / pause); n * pause <= last() + shift; n++)
    pen.fillText(+(n * pause).toFixed(6), Math.min(x(n * pause - shift), width - 12), height - 3);
  for (const name in chart.values) drawCurve(pen, chart.values[name], byNumber.get(+name), selected, start, x, y);
  pen.lineWidth = 1.5; pen.strokeStyle = KINDS.failed;
  pen.beginPath(); pen.moveTo(x(now), 2); pen.lineTo(x(now), height - 16); pen.stroke();
  const own = chart.values[0] || (selected && chart.values[selected.number]);
  chart.caption.textContent = chart.name + (own ? ` ${number(own[indexAt(now)], 3)} ${chart.unit}` : ` (${chart.unit})`);
}

function drawCurve(pen, values, robot, selected, start, x, y) {
  let down = false;
  pen.beginPath();
  for (let k = start; k < values.length; k++) {
    const isKnown = !isNaN(values[k]);
    if (isKnown && down) pen.lineTo(x(times[k]), y(values[k])); else if (isKnown) pen.moveTo(x(times[k]), y(values[k]));
    down = isKnown;
  }
  if (robot?.bright) { pen.lineWidth = 2.6; pen.strokeStyle = EDGE; pen.stroke(); }
  pen.lineWidth = robot && robot === selected ? 3 : 1.5; pen.strokeStyle = robot ? robot.colour : INK; pen.stroke();
}
