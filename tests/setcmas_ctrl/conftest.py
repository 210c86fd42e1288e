import textwrap

import pytest


@pytest.fixture
def script(tmp_path):
    """Write a control script and return its path."""

    def write(text, name='law.py'):
        path = tmp_path / name
        path.write_text(textwrap.dedent(text))
        return str(path)

    return write
