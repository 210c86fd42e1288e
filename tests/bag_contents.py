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


def write_compressed(path, store, messages, mode, plugin, chunk_ends=()):
    """Write messages compressed; after those at `chunk_ends` a new chunk begins."""
    writer = Writer(path, version=9, storage_plugin=plugin)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    connections = {}
    with writer:
        for i, (topic, _, message) in enumerate(messages):
            kind = message.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], i + 1, store.serialize_cdr(message, kind))
            if i in chunk_ends:
                writer.storage.close_chunk()


def damage(mcap, chunk):
    """Damage a compressed chunk of a file, by its number; its index stays."""
    content, at = bytearray(mcap.read_bytes()), -1
    for _ in range(chunk + 1):
        at = content.index(b'\x28\xb5\x2f\xfd', at + 1)  # of Zstandard
    content[at] ^= 0xFF
    mcap.write_bytes(content)
