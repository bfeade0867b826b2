#!/usr/bin/env bash
# Checks whether the ROS masters of this computer and another computer can be joined: names, ports, ROS_IP, connections between
# both masters, message definitions, clocks. For each problem it says what to do. See docs/how-to/multimaster.md.
#
#   scripts/check_network.sh HOST      run it in the shell that starts this side's launch; the other side must run
#
# Exit status 0: no problem found; 2: a problem found; 1: wrong input. Options: --master-port N, --discovery-port N.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

case "${1:-}" in '' | -h | --help) sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;; esac
prepare "${run_packages[@]}" >&2
exec rosrun graph_fleet_manager check_network "$@"
