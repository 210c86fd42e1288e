"""Statistics of arriving messages: rate, jitter, gaps and age."""

from __future__ import annotations

import itertools
import statistics
from dataclasses import dataclass

_PLAUSIBLE_AGE_S = (-0.005, 2.0)  # beyond, the clocks of the two machines differ


@dataclass(frozen=True)
class ArrivalStatistics:
    """The regularity of one topic.

    Attributes:
        rate: Messages per second.
        jitter: Standard deviation of the gaps between arrivals, in s.
        largest_gap: In s; the time before the first and after the last message counts.
        age: Median age at arrival by the message's stamp, in s; None where the clocks of sender
            and receiver differ, or stamps are not set.
    """

    rate: float
    jitter: float
    largest_gap: float
    age: float | None


def arrival_statistics(
    arrivals: list[float], stamps: list[float], begin: float, end: float
) -> ArrivalStatistics:
    """Return the regularity of messages that were awaited for a while.

    Args:
        arrivals: When each arrived, in s.
        stamps: When each was stamped, in s on a clock that should agree; 0 if it was not.
        begin: When the wait began, in s.
        end: When it ended, in s.
    """
    times = [begin, *arrivals, end]
    largest = max(later - earlier for earlier, later in itertools.pairwise(times))
    gaps = [later - earlier for earlier, later in itertools.pairwise(arrivals)]
    rate = len(gaps) / sum(gaps) if gaps and sum(gaps) > 0 else 0.0
    jitter = statistics.pstdev(gaps) if gaps else 0.0
    ages = [arrival - stamp for arrival, stamp in zip(arrivals, stamps, strict=True) if stamp]
    age = statistics.median(ages) if ages else None
    if age is not None and not _PLAUSIBLE_AGE_S[0] <= age <= _PLAUSIBLE_AGE_S[1]:
        age = None
    return ArrivalStatistics(rate, jitter, largest, age)
