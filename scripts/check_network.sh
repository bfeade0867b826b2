#!/usr/bin/env bash
# Looks whether this computer's ROS master can be joined with that of another: names, ports, ROS_IP, both masters' way to
# each other, message definitions, clocks; each with what to do. See docs/how-to/multimaster.md.
#
#   scripts/check_network.sh HOST      in the shell from which this side is launched, best while both sides run
#
# Exit status 0: all is well; 2: something is wrong; 1: wrong input. Options: --master-port N, --discovery-port N.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

case "${1:-}" in '' | -h | --help) sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;; esac
prepare "${run_packages[@]}" >&2
exec rosrun graph_fleet_manager check_network "$@"
