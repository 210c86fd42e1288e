"""What docs/nodes.md and docs/ros.md say of the nodes of a fleet is what a running fleet shows."""

import re
from pathlib import Path

from processes import SETCMAS

DOCS = Path(__file__).parents[1] / 'docs'
OF_ALL = {'use_sim_time', 'start_type_description_service', 'robot_no', 'fleet_namespace'}


def test_the_picture_of_the_nodes_is_the_graph_of_a_running_fleet(start, peer, monkeypatch):
    """`python docs/generators/nodes_picture.py` draws it anew."""
    monkeypatch.syspath_prepend(DOCS / 'generators')
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


def test_the_table_of_parameters_has_those_of_the_nodes(start, peer):
    from rcl_interfaces.srv import DescribeParameters, ListParameters

    _, _, rest = (DOCS / 'ros.md').read_text().partition('| node | can be set')
    table, _, _ = rest.partition('\n\n')
    rows = re.findall(r'^\| `(/\S+)` \|(.*)\|(.*)\|$', table, re.M)
    start(*SETCMAS, 'simu', '--nb-robots', '2')
    options = ('--algo', 'consensus', '--event-triggered', '--filter', 'barrier')
    start(*SETCMAS, 'ctrl', *options)

    for node, *told in rows:
        name = node.replace('tb3_i', 'tb3_2')
        listed = peer.call(ListParameters, f'{name}/list_parameters').result.names
        described = peer.call(DescribeParameters, f'{name}/describe_parameters', names=listed)
        shown = [set(), set()]
        for one in described.descriptors:
            shown[one.read_only].add(one.name)
        assert [part - OF_ALL for part in shown] == [set(re.findall(r'\w+', one)) for one in told]
    assert len(rows) == 7
