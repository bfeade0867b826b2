"""Runs a module of the packages in src/: python3 -I scripts/run_module.py MODULE [ARGUMENT...]

With -I, Python imports nothing from the working directory, from PYTHONPATH or from a user's folder.
So a program that root runs in another person's folder does not execute that person's code.
"""
from __future__ import annotations

import runpy
import sys
from pathlib import Path

if __name__ == '__main__':
    sources = Path(__file__).resolve().parents[1] / 'src'
    sys.path[:0] = sorted(str(folder) for folder in sources.glob('*/src'))
    del sys.argv[0]
    runpy.run_module(sys.argv[0], run_name='__main__', alter_sys=True)
