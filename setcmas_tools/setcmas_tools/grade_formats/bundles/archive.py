"""Zip archives that are the same whenever their files are."""

from __future__ import annotations

import io
import stat
import zipfile
from collections.abc import Mapping

_LONG_AGO = (1980, 1, 1, 0, 0, 0)  # the earliest that the format knows


def archive(files: Mapping[str, str | bytes]) -> bytes:
    """Return a zip archive of files by path; those that begin with `#!` can be executed."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, 'w', zipfile.ZIP_DEFLATED) as target:
        for path, text in files.items():
            data = text.encode() if isinstance(text, str) else text
            info = zipfile.ZipInfo(path, _LONG_AGO)
            mode = 0o755 if data.startswith(b'#!') else 0o644
            info.external_attr = (stat.S_IFREG | mode) << 16
            info.create_system = 3  # Unix, whose modes are kept
            target.writestr(info, data, zipfile.ZIP_DEFLATED)
    return content.getvalue()
