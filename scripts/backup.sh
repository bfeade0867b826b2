#!/usr/bin/env bash
# Saves a site (graph, fleet file, maps, journal) in one archive, secrets in another, and restores it: scripts/backup.sh --help
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
exec /usr/bin/python3 -I "$root/scripts/run_module.py" fleet_services.backup "$@"
