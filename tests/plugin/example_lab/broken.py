"""A plugin that raises on import."""

raise RuntimeError('no licence\nfound')
