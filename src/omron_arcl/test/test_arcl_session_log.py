"""Session logs are written as docs/interface/session_log.md says; the simulator reads them."""
from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from omron_arcl import SessionLog, session_log

ROOT = Path(__file__).resolve().parents[3]
VECTORS = yaml.safe_load((ROOT / 'test' / 'vectors' / 'session_log.yaml').read_text())


@pytest.mark.parametrize('row', VECTORS, ids=lambda row: row['line'])
def test_a_line_is_written_as_documented(row, tmp_path, monkeypatch):
    monkeypatch.setattr(session_log.time, 'time', lambda: row['time'])
    log = SessionLog(str(tmp_path / 'session.log'))
    traces = [log.outgoing(), *(log.connection() for _ in range(3))]
    traces[row['connection']](row['side'], bytes(row['bytes']))
    log.close()
    assert (tmp_path / 'session.log').read_text(encoding='ascii') == row['line'] + '\n'
