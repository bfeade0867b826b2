#!/usr/bin/env bash
# Brings fkie multimaster into this workspace: needed only where the fleet manager has its own ROS master. Installs what
# it imports, builds it in src/multimaster_fkie, and starts it once to see that it answers.
#
#   scripts/multimaster.sh                      sources from the address in catkin_ws.repos
#   FKIE_ARCHIVE=FILE scripts/multimaster.sh    sources from an archive (.tar.gz), without a network
#
# Sources that are there already are kept. On Ubuntu with Noetic, `apt-get install ros-noetic-fkie-multimaster` will do too.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

[ $# = 0 ] || { sed -n '2,8s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0; }

# answers: discovery and synchronisation run under a ROS master of their own, on the loopback interface, and answer.
answers() {
  local log="$root/build/multimaster.log" master_port launch verdict=0
  master_port="$(free_port)"
  export ROS_IP=127.0.0.2 ROS_MASTER_URI="http://127.0.0.2:$master_port" ROS_HOME="$root/build/ros_home"
  unset ROS_HOSTNAME
  roslaunch -p "$master_port" omron_ld90 multimaster.launch peer:=127.0.0.3 rpc_port:="$(free_port)" >"$log" 2>&1 &
  launch=$!
  trap "kill $launch 2>/dev/null || true" EXIT
  _answer /master_discovery/list_masters "$ROS_MASTER_URI" && _answer /master_sync/get_sync_info || verdict=1
  kill "$launch" 2>/dev/null && wait "$launch" || true
  trap - EXIT
  return "$verdict"
}

_answer() {  # SERVICE [WORD]: within 30 s it is offered, and its answer holds the word
  local deadline=$((SECONDS + 30)) answer
  while kill -0 "$launch" 2>/dev/null && [ "$SECONDS" -lt "$deadline" ]; do
    if answer="$(timeout 5 rosservice call "$1" 2>/dev/null)" && [[ "$answer" == *"${2:-}"* ]]; then return 0; fi
    sleep 0.2
  done
  return 1
}

if [ -n "${FKIE_ARCHIVE:-}" ]; then FKIE_ARCHIVE="$(realpath -m -- "$FKIE_ARCHIVE")"; fi
packages=("${run_packages[@]}" "${multimaster_packages[@]}")
checkout="$root/src/multimaster_fkie"
if ! [ -d "$checkout" ]; then
  say "Importing multimaster_fkie"
  [ -n "${FKIE_ARCHIVE:-}" ] || prepare "${packages[@]}"  # for git and vcs
  reason="$(import_multimaster "$checkout" 2>&1)" || die "$(tail -1 <<<"$reason")."
fi
prepare "${packages[@]}"
say "Starting discovery and synchronisation once"
answers || die "discovery and synchronisation were built but do not answer: $(
  sed 's/\x1b[^m]*m//g' "$root/build/multimaster.log" | grep -m1 -E 'Error|Exception' || echo 'they say nothing') (whole log: $root/build/multimaster.log)"
say "fkie multimaster is ready; docs/multimaster.md says how two masters are joined"
