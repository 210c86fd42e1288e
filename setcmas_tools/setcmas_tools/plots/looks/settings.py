"""Fonts, sizes and widths of all plots, as matplotlib's settings (rcParams)."""

from __future__ import annotations

from typing import Any

SCREEN: dict[str, Any] = {
    'figure.constrained_layout.use': True,
    'figure.dpi': 100,
    'savefig.dpi': 150,
    'font.size': 11,
    'axes.titlesize': 13,
    'axes.titlelocation': 'left',
    'axes.grid': True,
    'axes.axisbelow': True,
    'axes.spines.top': False,
    'axes.spines.right': False,
    'axes.edgecolor': '0.3',
    'grid.color': '0.9',
    'legend.fontsize': 10,
    'legend.frameon': False,
    'lines.linewidth': 1.6,
    'lines.markersize': 6.0,
    'lines.solid_capstyle': 'round',
    'lines.solid_joinstyle': 'round',
    'pdf.fonttype': 42,
    'svg.fonttype': 'path',
    'svg.hashsalt': 'setcmas',
}
"""On screens and slides."""

PAPER: dict[str, Any] = {
    'savefig.dpi': 600,
    'font.family': ['STIXGeneral', 'DejaVu Serif'],  # as Times; both come with matplotlib
    'mathtext.fontset': 'stix',
    'font.size': 8,
    'axes.labelsize': 8,
    'legend.fontsize': 7,
    'xtick.labelsize': 7,
    'ytick.labelsize': 7,
    'axes.linewidth': 0.6,
    'axes.labelpad': 2.0,
    'grid.linewidth': 0.5,
    'lines.linewidth': 0.9,
    'lines.markersize': 3.5,
    'legend.handlelength': 1.4,
    'legend.columnspacing': 1.0,
    'legend.handletextpad': 0.5,
    'legend.labelspacing': 0.25,
    'xtick.major.size': 2.5,
    'ytick.major.size': 2.5,
    'xtick.major.width': 0.6,
    'ytick.major.width': 0.6,
}
"""In a printed paper, on top of SCREEN: 8 pt letters at their true size."""
