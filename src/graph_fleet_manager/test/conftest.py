"""Makes the builders in this folder and those of fleet_core importable."""
from __future__ import annotations

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / 'fleet_core/test'))
