"""Recorder process: topics into a rosbag2 bag until a signal asks to stop."""

from __future__ import annotations

import argparse
import sys
import time

from setcmas_simu.fleet import topics
from setcmas_simu.reports.reports import WRITES_S, Recording
from setcmas_simu.ros.process import FleetNode, RosProcess, node_main
from setcmas_tools.bags.foxglove import write_layout
from setcmas_tools.recorder.graph_recorder import GraphRecorder
from setcmas_tools.recorder.options import RecorderOptions
from setcmas_tools.recorder.writer import BagWriter

_TAKE_PERIOD_S = 0.05
_LOCKSTEP_PERIOD_S = 0.005  # the robots wait
_LOOK_PERIOD_S = 0.2
_FLUSH_PERIOD_S = 1.0


def main(argv: list[str] | None = None) -> int:
    """Record; returns the exit status."""
    return node_main(_parser(), _record_bag, argv)


def _record_bag(process: RosProcess, args: argparse.Namespace) -> int:
    process.longest_end_s = int(WRITES_S)
    options = RecorderOptions.of(args)
    chosen = [f'/{name.lstrip("/")}' for name in options.topics or ()] or None
    try:
        with BagWriter(options.output) as writer:
            recorder = GraphRecorder(FleetNode(topics.RECORDER_NODE), writer, chosen)
            _record(process, recorder, writer)
        write_layout(options.output, writer.types)
    except OSError as error:
        reason = f'{error.strerror}; what was written before is readable'
        print(f"error: recording to '{options.output}' stopped: {reason}", file=sys.stderr)
        return 1
    for name in sorted(set(chosen or []) - set(recorder.recorded)):
        print(f'{name} was never published', file=sys.stderr)
    print(_summary(writer), flush=True)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='recorder',
        description='Record all topics but /parameter_events, /rosout and hidden ones (/_...) '
        'into a rosbag2 bag, new topics as they appear, until Ctrl-C.',
    )
    RecorderOptions.add_to(parser)
    return parser


def _record(process: RosProcess, recorder: GraphRecorder, writer: BagWriter) -> None:
    next_look = next_flush = 0.0
    told = False
    nb_topics = 0
    while not process.stopping:
        now = time.monotonic()
        if now >= next_look:
            next_look = now + _LOOK_PERIOD_S
            recorder.look()
            # Wait for a look that finds no more: topics of a node appear one after another.
            complete = 0 < nb_topics == len(recorder.recorded) and not recorder.missing()
            if not told and complete:
                told = True
                topics_text = 'topic' if nb_topics == 1 else 'topics'
                print(f'recording {nb_topics} {topics_text} to {writer.path}', flush=True)
                process.launcher.report(Recording(nb_topics))
            nb_topics = len(recorder.recorded)
        recorder.drain()
        if now >= next_flush:
            next_flush = now + _FLUSH_PERIOD_S
            writer.flush()
        time.sleep(_LOCKSTEP_PERIOD_S if recorder.follows else _TAKE_PERIOD_S)
    recorder.close()


def _summary(writer: BagWriter) -> str:
    if not writer.count:
        return f'nothing was recorded: no message came; {writer.path} is an empty bag'
    return f'recorded {writer} to {writer.path}'


if __name__ == '__main__':
    sys.exit(main())
