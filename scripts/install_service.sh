#!/usr/bin/env bash
# Runs a site as systemd services: scripts/install_service.sh --help
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

prepare "${run_packages[@]}" >&2
exec rosrun fleet_services install_service "$@"
