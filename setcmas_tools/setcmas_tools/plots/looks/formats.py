"""Formats of plots: files, palettes, and widths in a paper."""

FORMATS = ('png', 'pdf', 'svg')
"""File formats by their usual endings: PNG at 150 dpi (in a paper 600), and vector graphics."""

PALETTES = ('robots', 'okabe-ito')
"""The robots' own colours, or those that colour-blind readers can tell apart as well."""

PAPERS = {'column': 3.5, 'page': 7.16}
"""Widths in inches of a figure in one column, and across both, of a two-column paper (IEEE)."""

FILMS = ('mp4', 'gif')
"""Kinds of films."""
