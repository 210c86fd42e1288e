"""What the tests read from bags."""

from setcmas_tools.bag_reader import open_bag


def read(path):
    """Return the x of each message, and the notices."""
    with open_bag(path) as bag:
        x = [topic.type.decode(data).x for topic, _, data in bag.messages()]
        return x, bag.notices


def only_file(folder, pattern):
    (path,) = folder.glob(pattern)
    return path
