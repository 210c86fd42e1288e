"""Scripts of a running controller: loaded, blamed, ended, and loaded again."""
