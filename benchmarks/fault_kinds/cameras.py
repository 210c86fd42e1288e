"""Cameras as motion capture: faults of tags and cameras; `--mocap camera` adds other faults."""

from __future__ import annotations

from geometry_msgs.msg import PoseStamped
from rehearsal import STANDS_S, Rehearsal, Stop, stop_of

from fault_kinds.kind import Kind, Outcome, falls_silent, sends

OPTIONS = ('--mocap', 'camera', '--arena=-1.4,2.6,-1.5,1.5')
_LASTS_S = 2.0


def _fault(kind: str, line: str) -> Kind:
    return Kind(lambda r: r.fault(f'{kind} 1 {_LASTS_S}'), line, options=OPTIONS)


def _pose() -> PoseStamped:
    message = PoseStamped()
    message.pose.position.x = 1.0
    return message


def _goes_on(kind: str) -> Kind:
    """Return a fault in which poses stay right, so that no robot may stop."""

    def stops(r: Rehearsal, fault: float) -> Outcome:
        r.peer.spin(_LASTS_S + STANDS_S)
        assert not any(stop_of(samples, fault) for samples in r.truth.values()), r.output()[-3000:]
        return [Stop(0.0, 0.0)]

    return Kind(
        lambda r: r.fault(f'{kind} 1 {_LASTS_S}'), '', stops=stops, lets_go=True, options=OPTIONS
    )


KINDS = {
    'camera: glare': _fault('glare', 'robot 1'),
    'camera: hand over a tag': _fault('covered', 'robot 1'),
    'camera: two equal tags': _fault('twins', 'two tags have its number'),
    'camera: tag turned by 180 degrees': _fault('backwards', 'robot 1'),
    'camera: tag of another size': _fault('tag_size', 'its side measures'),
    'camera: camera bumped': _fault('bumped', 'was moved'),
    'camera: a tenth of the light': _fault('dark', 'no good pose'),
    'camera: no more pictures': _fault('stuck', 'no good pose'),
    'camera: printed at 97 percent': _goes_on('shrunk'),
    'camera: ten pictures a second': _goes_on('ten_frames'),
    'camera: poses on its topic': Kind(
        lambda r: sends(r, '/camera/tb3_1/pose', _pose()),
        'nodes send it',
        undo=falls_silent,
        options=OPTIONS,
    ),
    'camera: tag fallen off': _fault('fallen', 'its side measures'),
}
