"""Networks that lose the laptop, for good or for a while."""

from __future__ import annotations

import time
from collections.abc import Callable

from rehearsal import Rehearsal

from fault_kinds.kind import Kind, Place

_LAPTOP = 'laptop'


def _cut(seconds: float | None = None) -> Callable[[Rehearsal], float]:
    """Pull the laptop's plug; push it in again after a while, if given."""

    def cut(r: Rehearsal) -> float:
        now = time.time()
        r.network.cut(_LAPTOP)
        if seconds:
            r.peer.spin(seconds)
            r.network.restore(_LAPTOP)
        return now

    return cut


def _restore(r: Rehearsal) -> None:
    r.network.restore(_LAPTOP)


_LINE = 'no good pose|guard is silent'

KINDS = {
    "laptop's network cut": Kind(_cut(), '', place=Place.NETWORK),
    "laptop's network cut and back": Kind(_cut(), _LINE, _restore, place=Place.NETWORK),
    "laptop's network cut for 0.6 s": Kind(_cut(0.6), _LINE, place=Place.NETWORK),
}
