"""Picture of a soak: memory, threads, descriptors, sockets and ages of messages over time."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

import matplotlib as mpl

mpl.use('Agg')
import matplotlib.pyplot as plt
from soak_watch import Holding

Ages = Sequence[tuple[float, float, float]]


def picture(
    holdings: Mapping[str, Sequence[Holding]],
    ages: Ages,
    events: Sequence[tuple[float, str]],
    living: Collection[str],
    path: Path,
) -> None:
    """Draw what processes held, and how old messages were when they arrived.

    Args:
        holdings: What each process held, over time; those of one name, one after the other.
        ages: Time in s, median and 99th percentile of the ages in s.
        events: Time in s, and what happened.
        living: Processes that are there all the time: drawn as lines, the others as dots.
        path: The file to write.
    """
    figure, axes = plt.subplots(5, 1, figsize=(10, 12), sharex=True, layout='constrained')
    quantities = {
        'memory': 'own memory (MB)',
        'threads': 'threads',
        'descriptors': 'descriptors',
        'sockets': 'UDP sockets',
    }
    for axis, (name, label) in zip(axes, quantities.items(), strict=False):
        for process, samples in holdings.items():
            times = [one.at / 60 for one in samples]
            values = [getattr(one, name) for one in samples]
            style = {'lw': 1.5} if process in living else {'ls': '', 'marker': '.', 'ms': 3}
            axis.plot(times, values, label=process, **style)
        axis.set_ylabel(label)
        axis.set_ylim(bottom=0)
    axes[0].legend(ncols=4, fontsize='small', markerscale=3, loc='lower right')
    times = [at / 60 for at, _, _ in ages]
    axes[-1].semilogy(times, [1e3 * p99 for _, _, p99 in ages], label='99th percentile')
    axes[-1].semilogy(times, [1e3 * median for _, median, _ in ages], label='median')
    axes[-1].set_ylabel('age at arrival (ms)')
    axes[-1].set_xlabel('time (min)')
    axes[-1].legend(fontsize='small')
    for kind, colour in (('kill', 'tab:red'), ('reload', 'tab:green'), ('pause', 'tab:blue')):
        for at, event in events:
            if kind in event:
                axes[-1].axvline(at / 60, color=colour, lw=0.5, alpha=0.5)
    axes[-1].set_title('red: a process is killed; green: reload; blue: pause', fontsize='small')
    figure.savefig(path, dpi=110)
