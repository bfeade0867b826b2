#!/usr/bin/env bash
# Installs what is missing and builds, as scripts/run.sh does before it starts: for images, services and packages.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

[ $# = 0 ] || { sed -n '2s/^# //p' "${BASH_SOURCE[0]}"; exit 0; }
prepare "${run_packages[@]}"
