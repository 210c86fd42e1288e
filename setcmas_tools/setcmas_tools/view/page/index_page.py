"""The page's own HTML: viser's, under our title, with the panel folded on phones at first."""

from __future__ import annotations

import gzip

from websockets.http11 import Response

from setcmas_tools.view.page.keys import SCRIPT

_THEIR_TITLE, _TITLE = b'<title>Viser</title>', b'<title>setcmas</title>'
# On a phone viser opens the panel, which hides the scene; its server cannot tell it not to.
_FOLD = b"""
<script>
if (matchMedia('(max-width: 36em)').matches)
  new MutationObserver((_, observer) => {
    const handle = [...document.querySelectorAll('div')].find(
      div => div.style.cursor === 'pointer' && div.style.height === '3.5em');
    if (handle) { observer.disconnect(); handle.click(); }
  }).observe(document.documentElement, {childList: true, subtree: true});
</script>
"""


def dress(response: Response) -> None:
    """Make viser's page ours; other answers of its server stay as they are."""
    if not response.headers.get('Content-Type', '').startswith('text/html'):
        return
    packed = response.headers.get('Content-Encoding') == 'gzip'
    body = gzip.decompress(response.body) if packed else response.body
    body = body.replace(_THEIR_TITLE, _TITLE + _FOLD + SCRIPT.encode(), 1)
    response.body = gzip.compress(body, 1) if packed else body
    del response.headers['Content-Length']
    response.headers['Content-Length'] = str(len(response.body))
