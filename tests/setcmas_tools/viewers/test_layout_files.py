import json
from xml.etree import ElementTree

import pytest

from setcmas_tools.viewers.layout_files import write_layouts

TOPICS = {'/tb3_1/odom': 'nav_msgs/msg/Odometry'}


@pytest.mark.parametrize(
    ('bag', 'layouts'), [('out/bag', 'out/layouts'), ('bag_20261122', 'bag_20261122_layouts')]
)
def test_layouts_go_beside_the_bag_and_name_its_file(tmp_path, bag, layouts):
    (tmp_path / bag).mkdir(parents=True)

    folder = write_layouts(tmp_path / bag, TOPICS)

    assert folder == tmp_path / layouts
    assert 'configById' in json.loads((folder / 'foxglove.json').read_text())
    root = ElementTree.parse(folder / 'plotjuggler.xml').getroot()
    file = root.find('previouslyLoaded_Datafiles/fileInfo').get('filename')
    bag = tmp_path / bag
    assert (folder / file).resolve() == bag.resolve() / f'{bag.name}.mcap'


def test_without_robots_there_is_nothing_to_show(tmp_path):
    assert write_layouts(tmp_path / 'bag', {'/number': 'std_msgs/msg/UInt16'}) is None
    assert list(tmp_path.iterdir()) == []
