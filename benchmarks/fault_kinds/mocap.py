"""Motion capture that loses robots, or sends wrong poses; and bodies that others move."""

from __future__ import annotations

import itertools
import time

from rehearsal import Rehearsal, Stop

from fault_kinds.kind import Kind, Outcome

_LASTS_S = 2.0
_LONG_S = 60
_RESTS_S = 1.0


def _fault(kind: str, line: str) -> Kind:
    return Kind(lambda r: r.fault(f'{kind} 1 {_LASTS_S}'), line)


def _from_the_start(kind: str, line: str) -> Kind:
    """Return a fault that is there before robots first move: they do so at a crawl."""

    seen = {}

    def inject(r: Rehearsal) -> float:
        r.peer.wait_for(lambda: 'controlling robot' in r.output())
        r.fault(f'{kind} 1 {_LONG_S}')
        r.press_until(lambda: any(truth[-1].rolls > 0.0 for truth in r.truth.values()))
        seen['output'] = len(r.output())  # the fault may have paused robots that stood
        return time.time()

    def stops(r: Rehearsal, fault: float) -> Outcome:
        """Robots stand in turns while they prove who they are: look at the last of it."""
        r.peer.wait_for(lambda: 'paused: robot' in r.output()[seen['output'] :])
        r.peer.spin(_RESTS_S)
        rolled = [truth for truth in r.truth[1] if truth.stamp >= fault and truth.rolls]
        if not rolled:  # another robot showed it first
            return [Stop(0.0, 0.0)]
        metres = sum(
            after.rolls * (after.stamp - before.stamp)
            for before, after in itertools.pairwise(rolled)
        )
        return [Stop(rolled[-1].stamp - fault, metres)]

    return Kind(inject, line, stops=stops, moving=False)


KINDS = {
    'mocap dropout': _fault('dropout', 'no good pose'),
    'mocap nan': _fault('nan', 'rejected'),
    'mocap frozen': _fault('frozen', 'frozen'),
    'mocap jump': _fault('jump', 'jumped'),
    'mocap swapped names': _fault('swap', 'were names swapped'),
    'mocap late': _fault('late', 'no good pose'),
    'mocap drifts at 0.3 m/s': _fault('drift', 'robot 1'),
    'axes mirrored': _fault('mirrored', 'robot 1'),
    'body turned': _fault('turned', 'robot 1'),
    'axes mirrored from the start': _from_the_start('mirrored', 'paused: robot'),
    'body turned from the start': _from_the_start('turned', 'paused: robot'),
    'marker body fallen off': _fault('fallen', 'robot 1'),
    'robot lifted': _fault('lift', 'robot 1'),
    'robot blocked': _fault('blocked', 'robot 1'),
    "robot's wheels stand": _fault('stalled', 'robot 1'),
}
