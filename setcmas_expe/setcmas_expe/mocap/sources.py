"""Motion capture drivers: their topics, their message types, and how they lose a robot."""

from __future__ import annotations

from dataclasses import dataclass

from setcmas_simu.errors import SetcmasError

POSE_STAMPED = 'PoseStamped'
ODOMETRY = 'Odometry'
TRANSFORM_STAMPED = 'TransformStamped'
MESSAGE_TYPES = (POSE_STAMPED, ODOMETRY, TRANSFORM_STAMPED)
"""The types in which a driver may send a robot's pose."""

NAME = '{name}'
"""Stands in a topic template for the name of a rigid body."""

CUSTOM = 'custom'
"""The preset of a driver that is not in the table: topic and type are given."""

SILENCE = 'silence'
REPEATED = 'the last pose, repeated'
ZEROS = 'zeros: position 0, quaternion 0'
HUGE = 'the number 9999999.999999'


@dataclass(frozen=True)
class Preset:
    """What is known of a motion capture driver.

    Attributes:
        name: What the lab file calls it.
        topic: Template of the topic of a rigid body, with {name}.
        message_type: One of MESSAGE_TYPES.
        lost_looks_like: What may arrive when the system has lost a body, one or more of SILENCE,
            REPEATED, ZEROS and HUGE.
    """

    name: str
    topic: str
    message_type: str
    lost_looks_like: tuple[str, ...]


_TABLE = (
    Preset('qualisys', '/qualisys/{name}/odom', ODOMETRY, (SILENCE,)),
    Preset('vrpn', '/vrpn_mocap/{name}/pose', POSE_STAMPED, (SILENCE, REPEATED)),
    Preset('optitrack', '/{name}/pose', POSE_STAMPED, (SILENCE, REPEATED)),
    Preset('natnet', '/{name}/pose', POSE_STAMPED, (SILENCE, REPEATED)),
    Preset('nokov', '/{name}/pose', POSE_STAMPED, (SILENCE, HUGE)),
    Preset('vicon', '/vicon/{name}/{name}', POSE_STAMPED, (ZEROS,)),
)
PRESETS = {preset.name: preset for preset in _TABLE}
"""The presets by name; `custom` is not among them."""


def topic_of(template: str, mocap_name: str) -> str:
    """Return the topic of the rigid body of a name, from a template with {name}."""
    return template.replace(NAME, mocap_name)


def check_template(template: str) -> str:
    """Return a topic template.

    Raises:
        SetcmasError: It has no {name}, or would not be the full name of a topic.
    """
    letters = topic_of(template, 'a').replace('/', '').replace('_', '')
    named = NAME in template and template.startswith('/') and not template.endswith('/')
    if not (named and letters.isascii() and letters.isalnum() and '//' not in template):
        raise SetcmasError(
            f"topic '{template}' is not accepted; accepted is a full topic name with {NAME} for "
            f"the rigid body, such as '{PRESETS['vrpn'].topic}'"
        )
    return template
