"""Robots where they must not be: out of the arena, or too near to another."""

from __future__ import annotations

import math

from rehearsal import Rehearsal, Truth

from fault_kinds.kind import Kind, Outcome
from setcmas_expe.lab.lab_file import DEFAULT_FILE, load_lab

ARENA = load_lab(DEFAULT_FILE, 2).arena
SEPARATION = load_lab(DEFAULT_FILE, 2).min_separation


def _outside(truth: Truth) -> bool:
    return ARENA.distance(truth.x, truth.y) > 0


def _push(r: Rehearsal) -> float:
    """Return when the robot leaves the arena: only rolling on outwards is forbidden."""
    r.fault('push 1 6')
    r.peer.wait_for(lambda: _outside(r.truth[1][-1]))
    return next(truth for truth in reversed(r.truth[1]) if not _outside(truth)).stamp


def _stops_outwards(r: Rehearsal, fault: float) -> Outcome:
    def outwards(truth: Truth) -> float:
        normals = ARENA.outward_normals(truth.x, truth.y)
        return max((truth.rolls_towards(math.atan2(y, x)) for x, y in normals), default=0.0)

    return [r.wait_for_stop(fault, rolls=outwards)]


def _collide(r: Rehearsal) -> float:
    """Return when robots are too near: only rolling on towards each other is forbidden."""
    r.set_mode('collide')
    first, second = r.truth[1], r.truth[2]

    def gap() -> float:
        return math.hypot(first[-1].x - second[-1].x, first[-1].y - second[-1].y)

    r.peer.wait_for(lambda: gap() < SEPARATION, 60)
    return first[-1].stamp


def _stops_apart(r: Rehearsal, fault: float) -> Outcome:
    stops = []
    for robot, other in ((1, r.truth[2]), (2, r.truth[1])):
        place = other[-1]

        def towards(truth: Truth, place: Truth = place) -> float:
            return truth.rolls_towards(math.atan2(place.y - truth.y, place.x - truth.x))

        stops.append(r.wait_for_stop(fault, robot, towards))
    return stops


KINDS = {
    'pushed out of the arena': Kind(
        _push, 'outside the arena|was it pushed', stops=_stops_outwards, lets_go=True
    ),
    'collision course': Kind(
        _collide, 'closer than', stops=_stops_apart, lets_go=True, options=('--filter', 'none')
    ),
}
