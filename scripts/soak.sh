#!/usr/bin/env bash
# Runs a simulated fleet for hours with many kinds of faults; an independent witness judges the fleet.
#
#   scripts/soak.sh              one hour: 10 LD-90s and 10 AGVs at 5 times their speed
#   scripts/soak.sh 0.25 --seed 3 --ld90s 2 --agvs 2    a quarter of an hour, a small fleet
#   scripts/soak.sh --help       all options
#
# Exit status: 0: every promise held; 1: the report names the broken promises; 2: the fleet did not start.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

prepare "${run_packages[@]}"
ulimit -Sn 16384 2>/dev/null || ulimit -Sn "$(ulimit -Hn)"
export ROS_IP=127.0.0.1 PYTHONPATH="$root/scripts/bench:$root/test:$root/src/fleet_simulation/test${PYTHONPATH:+:$PYTHONPATH}"
exec /usr/bin/python3 "$root/scripts/soak/soak.py" "$@"
