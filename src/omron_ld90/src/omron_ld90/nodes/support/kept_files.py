"""JSON files in which a node keeps what must outlive its process."""
from __future__ import annotations

import json
import os
from typing import Any


def replace_json(path: str, content: Any) -> None:
    """Writes a file that is complete at any time; raises OSError.

    It is not forced to the disk: it must outlive the process, and nothing may wait for a disk.
    """
    os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
    part = f'{path}.part'
    with open(part, 'w', encoding='utf-8') as stream:
        json.dump(content, stream)
    os.replace(part, path)
