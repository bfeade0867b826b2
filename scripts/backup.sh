#!/usr/bin/env bash
# Saves a site (graph, fleet file, maps, journal) in one archive, secrets in another, and restores it: scripts/backup.sh --help
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
PYTHONPATH="$(printf '%s:' "$root"/src/*/src)${PYTHONPATH:-}" exec /usr/bin/python3 -m graph_fleet_manager.commands.site_backup "$@"
