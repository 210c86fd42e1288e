"""Report of a run whose law fails for two of its robots, and whose every text is hostile."""

from html.parser import HTMLParser

HOSTILE = '</script><img src=x onerror="document.title = 1">'

LAW = f"""'''{HOSTILE}'''
from setcmas_ctrl.laws.drawing import rviz_marker


def control(robotNo, nbRobots, poses, t):
    rviz_marker.publish_marker(t, 1.0, 0.0, robotNo, color=[1.0, 0.0, 0.0])
    if robotNo == 1 and t > 2:
        return poses[0, 7], 0.0
    if robotNo == 3 and 1 < t < 1.5:
        raise ValueError('''{HOSTILE}''')
    return 0.2 * robotNo, 0.1
"""

_VOID = {'meta', 'img', 'input'}


class Page(HTMLParser):
    """Reads a page; fails if its elements are not closed in order.

    Attributes:
        elements: Names of elements with their attributes.
        text: What can be read, by the innermost element that it is in.
    """

    def __init__(self, text):
        super().__init__()
        self.elements, self.text, self._open = [], [], []
        self.feed(text)
        self.close()
        assert not self._open

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in _VOID:
            self._open.append(tag)

    def handle_endtag(self, tag):
        if tag not in _VOID:
            assert self._open.pop() == tag

    def handle_data(self, data):
        if self._open:
            self.text.append((self._open[-1], data))

    @property
    def shown(self):
        """What is there to be read, without the scripts and styles of the page."""
        return ''.join(text for tag, text in self.text if tag not in ('script', 'style'))
