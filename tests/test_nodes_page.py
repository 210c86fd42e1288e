"""The picture of docs/nodes.md shows the nodes and topics of a fleet that runs."""

from pathlib import Path

from processes import SETCMAS

GENERATORS = Path(__file__).parents[1] / 'docs' / 'generators'


def test_the_picture_of_the_nodes_is_the_graph_of_a_running_fleet(start, peer, monkeypatch):
    """`python docs/generators/nodes_picture.py` draws it anew."""
    monkeypatch.syspath_prepend(GENERATORS)
    import nodes_picture

    for command in nodes_picture.COMMANDS:
        start(*SETCMAS, *command.split()[1:])
    graph = {}

    def is_complete():
        graph.update(nodes_picture.graph_seen_by(peer.node))
        return '/tb3_2/si_to_uni' in graph and all(one.process for one in graph.values())

    peer.wait_for(is_complete)
    peer.wait_for(
        lambda: (
            nodes_picture.picture(nodes_picture.graph_seen_by(peer.node))
            == nodes_picture.PICTURE.read_text()
        )
    )
