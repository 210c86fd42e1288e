"""Files of a bag, and the reader for each of them.

rosbags' AnyReader is not used: it refuses a whole bag for one topic with a definition that it
cannot use, files of a bag that define a type differently, and every file that was cut short.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag2 import Reader as Ros2Reader

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags.mcap_salvage import McapSalvage
from setcmas_tools.bags.source import BagSource, IndexedSource, one_line

_BAGS = 'a rosbag2 folder, an .mcap or a .db3 file, or a ROS 1 .bag file'


def open_sources(path: Path, stack: ExitStack) -> list[BagSource]:
    """Open the files of a bag.

    Args:
        path: A rosbag2 folder with or without its metadata.yaml, an .mcap or a .db3 file, a
            ROS 1 .bag file, or the folder of a run that holds a folder `bag`.
        stack: Closes the files in the end.

    Returns:
        One source for each file that can be read, at least one.

    Raises:
        SetcmasError: There is no such path, it is not a bag, or no file of it can be read.
        OSError: A file cannot be read for a reason outside of it.
    """
    if not path.exists():
        raise SetcmasError(f"there is no bag '{path}'; it must be {_BAGS}")
    if path.is_dir() and _is_compressed(path):
        return [_opened(_open_folder, path, stack)]
    sources, failures = [], []
    for file in _files(path):
        try:
            sources.append(_opened(_open_file, file, stack))
        except SetcmasError as error:
            failures.append(error)
    if not sources:
        raise failures[0]
    # Only of a bag in several files, whose recorder was killed just after it began a new one.
    sources[0].notices[:0] = map(str, failures)
    return sources


def _opened(opener: Callable[[Path], BagSource], path: Path, stack: ExitStack) -> BagSource:
    source = opener(path)
    stack.callback(source.close)
    return source


def _files(path: Path) -> list[Path]:
    if path.is_file():
        return [path]
    # metadata.yaml is not needed: it is missing after a kill, and slower to parse than the files.
    files = [file for file in sorted(path.iterdir()) if file.suffix in ('.mcap', '.db3')]
    if not files and (path / 'bag').is_dir():
        return _files(path / 'bag')
    if not files:
        raise SetcmasError(f"folder '{path}' is not a bag; it must be {_BAGS}")
    return files


def _is_compressed(folder: Path) -> bool:
    try:
        metadata = (folder / 'metadata.yaml').read_text(encoding='utf-8', errors='replace')
    except FileNotFoundError:
        return False
    pattern = r'^\s*compression_mode:\s*[\'"]?(file|message)'
    return bool(re.search(pattern, metadata, re.IGNORECASE | re.MULTILINE))


def _open_file(file: Path) -> BagSource:
    openers: dict[str, Callable[[Path], BagSource]] = {
        '.mcap': _open_mcap,
        '.db3': _open_db3,
        '.bag': _open_ros1,
        '.active': _open_ros1,  # x.bag.active, of a rosbag that was killed
    }
    if file.suffix not in openers:
        raise SetcmasError(f"'{file}' is not a bag; it must be {_BAGS}")
    if not file.stat().st_size:
        raise SetcmasError(f"bag '{file}' is empty: nothing was ever written to it")
    return openers[file.suffix](file)


def _open_mcap(file: Path) -> BagSource:
    try:
        return IndexedSource(file, Ros2Reader(file))
    except Exception:  # its index, the last to be written, is missing or damaged
        return McapSalvage(file)


def _open_db3(file: Path) -> BagSource:
    if Path(f'{file}-wal').exists():  # rosbags would not look into it
        raise SetcmasError(
            f"bag '{file}' was not closed; this closes it: "
            f"sqlite3 '{file}' 'PRAGMA journal_mode=DELETE'"
        )
    return _open_whole(
        file,
        Ros2Reader,
        'it must be whole (sqlite3 FILE .recover saves a cut one), with no #, ? or % in its path',
    )


def _open_ros1(file: Path) -> BagSource:
    return _open_whole(file, Ros1Reader, 'it must be whole (rosbag reindex repairs a cut one)')


def _open_folder(folder: Path) -> BagSource:
    return _open_whole(folder, Ros2Reader, 'a compressed bag must be whole')


def _open_whole(path: Path, reader: type[Ros1Reader] | type[Ros2Reader], advice: str) -> BagSource:
    try:
        return IndexedSource(path, reader(path))
    except Exception as error:  # a damaged file makes any of several libraries fail
        raise SetcmasError(f"bag '{path}' cannot be read ({one_line(error)}); {advice}") from error
