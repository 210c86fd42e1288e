// What drawings share: canvases as sharp as the screen, colours, numbers.

export const find = id => document.getElementById(id);
export const INK = '#1b1f24', SOFT = '#57606a', LINE = '#d8dee4', EDGE = '#404040';
export const KINDS = {failed: '#cf222e', stopped: '#cf222e', overruled: '#8250df', saturated: '#bf8700'};

export function sized(canvas) {
  const box = canvas.getBoundingClientRect(), ratio = window.devicePixelRatio || 1;
  const width = Math.round(box.width * ratio), height = Math.round(box.height * ratio);
  if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
  const pen = canvas.getContext('2d', {willReadFrequently: true});  // drawn by the processor: 15 times faster without a graphics card
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, box.width, box.height);
  pen.font = `${0.75 * parseFloat(getComputedStyle(document.documentElement).fontSize)}px system-ui, sans-serif`;
  pen.lineJoin = pen.lineCap = 'round';
  return {pen, width: box.width, height: box.height};
}

// The least of 1, 2, 5, 10, ... that divides a span into no more parts than given.
export function roundStep(span, most) {
  const power = 10 ** Math.floor(Math.log10(span / most));
  return [1, 2, 5, 10].map(one => one * power).find(one => span / one <= most);
}
export const digitsOf = step => Math.max(0, -Math.floor(Math.log10(step) + 1e-6));

// A number without a minus before what is rounded to 0.
export function number(value, digits) {
  if (!isFinite(value)) return '–';
  return value.toFixed(digits).replace(/^-(0\.?0*)$/, '$1').replace('-', '−');
}
