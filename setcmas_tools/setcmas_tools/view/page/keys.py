"""Keys and charts of the page of a run: they press its buttons, and drag its slider.

Buttons are found by what is written on them, the slider by what is above it.
"""

from __future__ import annotations

import json

PLAY, PAUSE = 'Play', 'Hold'
HOME, BACK, FORTH, END = '«', '‹', '›', '»'
SLOWER, FASTER = 'slower', 'faster'

TIME_BAR = 'setcmas-time'
"""Class of what is written above the slider."""

_KEYS = {
    ' ': (PLAY, PAUSE),
    'ArrowLeft': (BACK,),
    'ArrowRight': (FORTH,),
    'Home': (HOME,),
    'End': (END,),
    '-': (SLOWER,),
    '+': (FASTER,),
    '=': (FASTER,),  # where + needs Shift
}
# Before viser's own keys, which turn the camera.
SCRIPT = f"""
<script>
const keys = {json.dumps(_KEYS)};
window.addEventListener('keydown', event => {{
  const names = keys[event.key];
  if (!names || event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.target.closest && event.target.closest('input, textarea')) return;
  const buttons = [...document.querySelectorAll('button')];
  const named = wanted => buttons.find(button => wanted.includes(button.textContent.trim()));
  if (!named(['{HOME}'])) return;  // the page of a fleet that runs
  event.preventDefault();
  event.stopImmediatePropagation();
  named(names).click();
}}, true);
const seek = event => {{
  const chart = event.buttons === 1 && event.target.closest && event.target.closest('.u-over');
  let box = chart && document.querySelector('.{TIME_BAR}');
  while (box && !box.querySelector('.mantine-Slider-root')) box = box.parentElement;
  if (!box) return;
  const slider = box.querySelector('.mantine-Slider-trackContainer');
  const from = chart.getBoundingClientRect(), to = slider.getBoundingClientRect();
  const clientX = to.left + (event.clientX - from.left) / from.width * to.width;
  slider.dispatchEvent(new MouseEvent('mousedown', {{bubbles: true, clientX, clientY: to.top}}));
  document.dispatchEvent(new MouseEvent('mouseup', {{bubbles: true}}));
}};
window.addEventListener('mousedown', seek);
window.addEventListener('mousemove', seek);
</script>
"""
