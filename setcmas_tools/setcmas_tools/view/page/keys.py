"""Keys of the page of a run: each presses a button, which is found by what is written on it."""

from __future__ import annotations

import json

PLAY, PAUSE = 'Play', 'Hold'
HOME, BACK, FORTH, END = '«', '‹', '›', '»'
SLOWER, FASTER = 'slower', 'faster'

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
</script>
"""
