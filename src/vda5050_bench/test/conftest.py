"""Makes the builders in this folder and those of vda5050_protocol importable."""
from __future__ import annotations

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / 'vda5050_protocol/test'))
