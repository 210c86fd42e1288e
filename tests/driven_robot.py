"""A TurtleBot3 under motion capture, driven 20 times a second: its faults are those of a lab."""

import cmath
import math
import random
from collections import deque

from setcmas_expe.bridge.motion_check import MotionCheck
from setcmas_expe.emulation.emulated_fleet import truncated
from setcmas_simu.fleet.planar_pose import wrap_angle
from setcmas_simu.robots.model import ROBOT_LIMITS

STEP_S = 0.01
DECIDES_EVERY = 5  # steps
BURGER = ROBOT_LIMITS['burger']


class DrivenRobot:
    """Delay, lag, saturation, slip and wrong radii of the robot; noise, latency of its poses.

    Attributes:
        now: Time in s.
        V, omega: What the robot is commanded (m/s, rad/s), until it is changed.
        check: Judges its motion.
        found: What the check found last; None if nothing.
        spoil: Turns its true pose (place x + iy, heading) into what motion capture sees.
        blocked: What its wheels do: '' roll, 'slip' or 'stand'.
        path: Metres that its wheels have rolled.
    """

    def __init__(self, seed=0, rate=50.0):
        self.rng = rng = random.Random(seed)
        self.now = 100.0
        self.V = self.omega = self.path = 0.0
        self.check, self.found = MotionCheck(), None
        self.crawls = False
        self.spoil = lambda place, heading: (place, heading)
        self.blocked = ''
        self.heading = rng.uniform(-3, 3)
        self.place = complex(rng.uniform(-2, 2), rng.uniform(-2, 2))
        self.measured = None
        self._delay = round(rng.uniform(0.02, 0.12) / STEP_S)
        self._lag = rng.uniform(0.02, 0.12)
        self.gain = rng.uniform(0.92, 1.02), rng.uniform(0.9, 1.05)
        self._offset = cmath.rect(rng.uniform(0, 0.03), rng.uniform(-3, 3))  # of the body
        self._latency = round(rng.uniform(0.01, 0.04) / STEP_S)
        self._frames = max(1, round(1 / rate / STEP_S))
        self._orders = deque([(0.0, 0.0)] * (self._delay + 1), self._delay + 1)
        self._seen = deque(maxlen=self._latency + 1)
        self._speeds = 0.0, 0.0
        self._steps = 0

    def run(self, seconds, law=None):
        """Drive; `law` is called five times a second. Returns when it was found out."""
        for _ in range(round(seconds / STEP_S)):
            if law and self._steps % 20 == 0:
                self.V, self.omega = law(self)
            self._step()
            if self.found:
                return self.now
        return None

    def _step(self):
        self.now += STEP_S
        self._steps += 1
        self._move()
        self._seen.append(self._pose())
        if self._steps % self._frames == 0:
            self.measured = *self._seen[0], self.now
        if self._steps % DECIDES_EVERY == 0 and self.measured:
            self._decide()

    def _decide(self):
        x, y, heading, seen = self.measured
        self.found = self.check.step((x, y, heading), seen, self.now, *2 * [self.crawls])
        self.V, self.omega = BURGER.scaled_down(self.V, self.omega)
        self.check.command(self.V, self.omega, self.now)

    def _move(self):
        self._orders.append((truncated(self.V), truncated(self.omega)))
        share = 1 - math.exp(-STEP_S / self._lag)
        wanted = BURGER.saturate(*self._orders[0])
        self._speeds = tuple(
            float(v + share * (w - v)) for v, w in zip(self._speeds, wanted, strict=True)
        )
        V, omega = (speed * gain for speed, gain in zip(self._speeds, self.gain, strict=True))
        self.path += 0.0 if self.blocked == 'stand' else abs(V) * STEP_S
        if not self.blocked:
            self.heading += omega * STEP_S
            self.place += V * STEP_S * cmath.exp(1j * self.heading)

    def _pose(self):
        place = self.place + self._offset * cmath.exp(1j * self.heading)
        place, heading = self.spoil(place, self.heading)
        noise = self.rng.gauss
        return (
            place.real + noise(0, 3e-4),
            place.imag + noise(0, 3e-4),
            float(wrap_angle(heading + noise(0, 3e-3))),
        )


def to_points(every=6.0):
    """Return a law that drives to random points, as si_to_uni does it."""
    goal, until = 0j, 0.0

    def law(robot):
        nonlocal goal, until
        if robot.now >= until:
            goal = complex(robot.rng.uniform(-2, 2), robot.rng.uniform(-2, 2))
            until = robot.now + every
        way = goal - robot.place
        speed = min(0.5, abs(way))
        if speed < 0.01:
            return speed, 0.0
        error = float(wrap_angle(cmath.phase(way) - robot.heading))
        return speed, 1.5 * error

    return law


def back_and_forth(robot):
    """Change all signs at random: the hardest that a law may do."""
    return robot.rng.choice((-0.21, 0.0, 0.21)), robot.rng.choice((-2.6, 0.0, 2.6))


def turns(robot):
    """Turn on the spot, now this way, now that way."""
    return 0.0, 2.6 * math.sin(robot.now)
