"""Objects that a fork makes are on memory pages that only this fork uses."""
from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

SOURCES = Path(__file__).resolve().parents[1] / 'src'
PROGRAM = '''
import sys
from node_host import shared_memory
size = int(sys.argv[1]) - sys.getsizeof(b'')
shared = [bytes(size) for _ in range(20000)]
del shared[::100]
if sys.argv[2:]:
    shared_memory.fill_holes()
pages = {id(one) >> 12 for one in shared}
made = [bytes(size) for _ in range(150)]
print(sum(id(one) >> 12 in pages for one in made))
'''


def on_shared_pages(size: int, *options: str) -> int:
    """Makes 150 new objects in a process whose older objects have 200 holes between them.

    Returns how many of the new objects are on pages with older objects.
    """
    return int(subprocess.run([sys.executable, '-c', PROGRAM, str(size), *options], check=True,
                              env={'PYTHONPATH': str(SOURCES)}, stdout=subprocess.PIPE,
                              text=True).stdout)


@pytest.mark.parametrize('size', [48, 64, 96, 256, 512])
def test_new_objects_do_not_lie_between_older_ones(size: int) -> None:
    assert on_shared_pages(size) > 100, 'without fill_holes they must'
    assert on_shared_pages(size, 'filled') < 50
