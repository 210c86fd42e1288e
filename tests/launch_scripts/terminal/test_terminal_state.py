import os
import pty
import subprocess
import sys

CODE = """
import os
from launch_scripts.terminal.terminal_state import kept_terminal
with kept_terminal():
    os.system('stty -echo raw')
"""


def test_a_terminal_that_a_script_has_changed_is_given_back():
    import termios

    terminal, inner = pty.openpty()
    before = termios.tcgetattr(inner)

    subprocess.run([sys.executable, '-c', CODE], stdin=inner, check=True)

    assert termios.tcgetattr(inner) == before
    os.close(terminal)
    os.close(inner)
