"""The layout files beside a bag: layouts/foxglove.json and layouts/plotjuggler.xml."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path

from setcmas_tools.run.source import stem_of_bag
from setcmas_tools.viewers.foxglove import foxglove_layout
from setcmas_tools.viewers.plotjuggler import plotjuggler_layout
from setcmas_tools.viewers.recording import RecordedTopics


def write_layouts(bag: Path, types: Mapping[str, str]) -> Path | None:
    """Write layouts for other programs; those of a folder named bag go to `layouts` beside it.

    Args:
        bag: The folder of the bag.
        types: The message types of its topics by name.

    Returns:
        The folder of the layouts; None without robots, for which there is nothing to show.

    Raises:
        OSError: They cannot be written.
    """
    recording = RecordedTopics(types)
    if not recording.odometry:
        return None
    folder = bag.parent / f'{stem_of_bag(bag)}layouts'
    folder.mkdir(exist_ok=True)
    layout = json.dumps(foxglove_layout(recording), indent=1)
    (folder / 'foxglove.json').write_text(f'{layout}\n', encoding='utf-8')
    file = Path(os.path.relpath(bag, folder), f'{bag.name}.mcap').as_posix()
    layout = plotjuggler_layout(recording, file)
    (folder / 'plotjuggler.xml').write_text(f'{layout}\n', encoding='utf-8')
    return folder
