"""Metrics of communication: triggers, and messages sent, received and lost."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from setcmas_tools.measures.metric import Columns, Measured
from setcmas_tools.run.communication_record import agreement_time
from setcmas_tools.run.run import Run


@dataclass(frozen=True)
class CommunicationMetrics(Measured):
    """Messages of a run; those of a robot are the ones it sent.

    Attributes:
        evaluations: Evaluations of triggering conditions; None if communication was periodic.
        triggered_share: Share of the evaluations that triggered; None if it was periodic.
        least_interval_s: Shortest time between two states of a robot; None if it was periodic, or
            if no robot sent two.
        sent: States that robots broadcast.
        received: Messages that arrived, over all links; None if not counted, as in ROS 1.
        lost: Messages that were lost, over all links; None likewise.
        loss_ratio: lost / (received + lost); None without messages.
        broken_links: Number of times that a link ended.
        agreement_time_s: Time from which all laws send the same value; None if they do not.
        received_by_others: Messages of each robot that arrived; empty if not counted.
        lost_on_the_way: Messages of each robot that were lost; empty if not counted.
        mean_interval_s: Mean time between broadcasts of each robot; None for fewer than two.
    """

    evaluations: int | None
    triggered_share: float | None
    least_interval_s: float | None
    sent: int
    received: int | None
    lost: int | None
    loss_ratio: float | None
    broken_links: int
    agreement_time_s: float | None
    received_by_others: dict[int, int]
    lost_on_the_way: dict[int, int]
    mean_interval_s: dict[int, float | None]

    def columns(self) -> Columns:
        """Return the messages of each robot."""
        return {
            'every\n(s)': ('.2f', self.mean_interval_s),
            'arrived': ('.0f', self.received_by_others),
            'lost': ('.0f', self.lost_on_the_way),
        }

    def lines(self) -> list[str]:
        """Return the messages of the fleet."""
        sent = f'{self.sent:,} states sent'
        if self.evaluations and self.triggered_share is not None:
            share = f'{100 * self.triggered_share:.1f} % of {self.evaluations:,} evaluations'
            sent += f' ({share} triggered)'
        if self.least_interval_s is not None:
            sent += f', those of a robot at least {self.least_interval_s:.2f} s apart'
        if self.received is None:
            return [f'communication: {sent}']
        loss = '' if self.loss_ratio is None else f' ({100 * self.loss_ratio:.1f} %)'
        return [
            f'communication: {sent}, {self.received:,} messages received, {self.lost:,} lost{loss}'
        ]


def fleet_communication(run: Run) -> CommunicationMetrics | None:
    """Return how much the robots of a run communicated; None without a record."""
    record = run.record
    if not record:
        return None
    robots = record.robots
    sent = sum(counts.sent for counts in robots.values())
    received = sum(counts.received for counts in robots.values())
    lost = sum(counts.lost for counts in robots.values())
    evaluations = len(record.triggers) or None
    intervals = np.concatenate([np.empty(0), *record.intervals.values()])
    return CommunicationMetrics(
        evaluations=evaluations,
        triggered_share=sent / evaluations if evaluations else None,
        least_interval_s=float(intervals.min()) if len(intervals) else None,
        sent=sent,
        received=received if record.links else None,
        lost=lost if record.links else None,
        loss_ratio=lost / (received + lost) if received + lost else None,
        broken_links=int(np.sum(record.changes[:, 3] == 0.0)),
        agreement_time_s=agreement_time(run.messages, len(run.robots)),
        received_by_others={i: counts.received for i, counts in robots.items() if record.links},
        lost_on_the_way={i: counts.lost for i, counts in robots.items() if record.links},
        mean_interval_s={
            robot: counts.mean_interval if math.isfinite(counts.mean_interval) else None
            for robot, counts in robots.items()
        },
    )
