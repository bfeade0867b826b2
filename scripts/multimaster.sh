#!/usr/bin/env bash
# Imports fkie multimaster (catkin_ws.repos) into src/ and builds it: needed only where the fleet manager has
# its own ROS master. On Ubuntu with Noetic, `apt-get install ros-noetic-fkie-multimaster` does the same.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

[ $# = 0 ] || { sed -n '2,3s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0; }

import_packages=(
  "git                 git"
  "python3-grpc-tools  python3-grpc-tools"
  "python3-grpcio      python3-grpcio"
  "python3-netifaces   python3-netifaces"
  "vcstool             python3-vcstool"
)
checkout="$root/src/multimaster_fkie"
if ! [ -d "$checkout" ]; then
  prepare "${run_packages[@]}" "${import_packages[@]}"
  say "Importing multimaster_fkie"
  (cd "$root" && vcs import --input catkin_ws.repos src) || {
    rm -rf "$checkout"
    die "multimaster_fkie could not be cloned (is there a network?); the address is in catkin_ws.repos."
  }
  # Two joined masters need discovery, synchronisation and their messages only.
  touch "$checkout"/{fkie_multimaster,fkie_node_manager,fkie_node_manager_daemon}/CATKIN_IGNORE
fi
prepare "${run_packages[@]}" "${import_packages[@]}"
rospack find fkie_master_sync >/dev/null || die "fkie_master_sync was built but ROS does not find it; see $root/build/build.log."
say "fkie multimaster is ready; docs/multimaster.md says how two masters are joined"
