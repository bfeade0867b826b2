"""The static files of the page, read once at the start. A path in a request never reaches the disk.
"""
from __future__ import annotations

import gzip
import hashlib
import os
from dataclasses import dataclass
from typing import Dict, Optional

from aiohttp import web

CHART = '/usr/share/javascript/chart.js/chart.min.js'
_CHART_MARK = b'Chart.js v3'  # Chart.js 2 has different calls
_LOOKED_AT = 300              # bytes at the beginning of the file; they contain the version
_KINDS = {'.html': 'text/html', '.css': 'text/css', '.js': 'text/javascript',
          '.json': 'application/json', '.svg': 'image/svg+xml'}


@dataclass(frozen=True)
class _File:
    content: bytes
    compressed: bytes
    kind: str
    tag: str


class PageFiles:
    """All files of a folder, and Chart.js if the operating system has it in a new enough version.
    """

    def __init__(self, folder: str, chart: str = CHART) -> None:
        self._files: Dict[str, _File] = {}
        for name in sorted(os.listdir(folder)):
            kind = _KINDS.get(os.path.splitext(name)[1])
            if kind is not None:
                self._files[name] = _file(_read(os.path.join(folder, name)), kind)
        try:
            content: Optional[bytes] = _read(chart)
        except OSError:
            content = None
        if content is not None and _CHART_MARK in content[:_LOOKED_AT]:
            self._files['chart.js'] = _file(content, _KINDS['.js'])

    def answer(self, request: web.Request, name: str) -> web.StreamResponse:
        """Answers a request with the file of this name, or with 404."""
        file = self._files.get(name)
        if file is None:
            raise web.HTTPNotFound(reason='There is no such file.')
        headers = {'ETag': file.tag, 'Cache-Control': 'no-cache', 'Vary': 'Accept-Encoding'}
        if request.headers.get('If-None-Match') == file.tag:
            return web.Response(status=304, headers=headers)
        if 'gzip' in request.headers.get('Accept-Encoding', ''):
            headers['Content-Encoding'] = 'gzip'
        return web.Response(
            body=file.compressed if 'Content-Encoding' in headers else file.content,
            content_type=file.kind, charset='utf-8', headers=headers)


def _file(content: bytes, kind: str) -> _File:
    return _File(content, gzip.compress(content, 6), kind,
                 f'"{hashlib.sha256(content).hexdigest()[:20]}"')


def _read(path: str) -> bytes:
    with open(path, 'rb') as stream:
        return stream.read()
