#!/usr/bin/env bash
# Installs missing packages and builds the workspace, like the first part of scripts/run.sh. For images, services and packages.
#
#   scripts/build.sh              both
#   scripts/build.sh --packages   only installs missing packages, for a clone in the src folder of another workspace
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

case "$*" in
  '') prepare "${run_packages[@]}" ;;
  --packages) install_packages "${run_packages[@]}" ;;
  *) sed -n '2,5s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; [ "$*" = -h ] || [ "$*" = --help ] ;;
esac
