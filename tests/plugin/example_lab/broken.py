"""A plugin that raises while it is imported."""

raise RuntimeError('no licence\nfound')
