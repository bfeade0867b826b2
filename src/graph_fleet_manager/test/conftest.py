"""Makes the builders here and in fleet_core, and the world of fleet_simulation, importable."""
from __future__ import annotations

import sys
from pathlib import Path

SOURCES = Path(__file__).resolve().parents[2]
sys.path += [str(SOURCES / 'fleet_core/test'), str(SOURCES / 'fleet_simulation/test')]
