"""The TurtleBot3 Burger."""

from __future__ import annotations

from setcmas_simu.robots.turtlebot3 import TurtleBot3
from setcmas_simu.robots.unicycle import BURGER_SHAPE
from setcmas_simu.robots.velocity_limits import ROBOT_MODELS

BURGER = TurtleBot3(ROBOT_MODELS['burger'], BURGER_SHAPE)
"""Limits of its OpenCR firmware; 138 x 178 x 192 mm (ROBOTIS' manual)."""
