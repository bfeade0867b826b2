#!/usr/bin/env python3
"""Follows README, tutorials and some how-to pages from the first command to the last."""
from __future__ import annotations

import subprocess
import unittest
from pathlib import Path
from typing import Callable

from page_commands import PAGES, alone

from system_support import run_cases


class Pages(unittest.TestCase):

    def setUp(self) -> None:
        tried = subprocess.run([*alone(Path())[:-3], 'true'], check=False, capture_output=True,
                               text=True)
        if tried.returncode:
            self.skipTest(f'no namespaces can be made here: {tried.stderr.strip()}')

    def follow(self, page: Path) -> None:
        done = subprocess.run(alone(page), check=False, text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, 0, done.stdout[-6000:])


def follower(page: Path) -> Callable[[Pages], None]:
    return lambda self: self.follow(page)


for page in PAGES:
    setattr(Pages, f'test_{page.stem.lower()}', follower(page))


if __name__ == '__main__':
    run_cases(__file__)
