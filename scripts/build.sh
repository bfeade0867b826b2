#!/usr/bin/env bash
# Installs missing packages and builds the workspace, as scripts/run.sh does before it starts. For images, services and packages.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

[ $# = 0 ] || { sed -n '2s/^# //p' "${BASH_SOURCE[0]}"; exit 0; }
prepare "${run_packages[@]}"
