"""What the tests read from bags, and compressed bags to be read."""

from rosbags.rosbag2 import CompressionFormat, Writer

from setcmas_tools.bags.bag_reader import open_bag


def read(path):
    """Return the x of each message, and the notices."""
    with open_bag(path) as bag:
        x = [topic.decode(data).x for topic, _, data in bag.messages()]
        return x, bag.notices


def only_file(folder, pattern):
    (path,) = folder.glob(pattern)
    return path


def write_compressed(path, store, points, mode, plugin, chunk_ends=()):
    """Write messages compressed; after those at `chunk_ends` a new chunk begins."""
    writer = Writer(path, version=9, storage_plugin=plugin)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        msgtype = points[0][2].__msgtype__
        connection = writer.add_connection('/points', msgtype, typestore=store)
        for i, (_, _, message) in enumerate(points):
            writer.write(connection, i + 1, store.serialize_cdr(message, msgtype))
            if i in chunk_ends:
                writer.storage.close_chunk()
