#!/usr/bin/env bash
# Adds fkie multimaster to this workspace. It is needed only if the fleet manager has its own ROS master. Installs the packages
# that it imports, builds it in src/multimaster_fkie, and joins two masters on this machine once to check that it works.
#
#   scripts/multimaster.sh                      sources from the address in catkin_ws.repos
#   FKIE_ARCHIVE=FILE scripts/multimaster.sh    sources from an archive (.tar.gz), without a network
#
# Existing sources are kept. On Ubuntu with Noetic, `apt-get install ros-noetic-fkie-multimaster` is enough.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

[ $# = 0 ] || { sed -n '2,8s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0; }

# find_each_other: starts two ROS masters on two addresses of the loopback interface, with the launch file that joins them.
# Succeeds if discovery on each side lists the other side, and synchronisation answers on both.
find_each_other() {
  local log="$root/build/multimaster.log" verdict=0 ports
  export ROS_HOME="$root/build/ros_home"
  unset ROS_HOSTNAME
  ports=("$(free_port)" "$(free_port)")
  _join 127.0.0.2 "${ports[0]}" 127.0.0.3 >"$log" 2>&1 &
  launches=("$!")
  _join 127.0.0.3 "${ports[1]}" 127.0.0.2 >>"$log" 2>&1 &
  launches+=("$!")
  trap 'kill "${launches[@]}" 2>/dev/null || true' EXIT
  { _answers 127.0.0.2 "${ports[0]}" /master_discovery/list_masters "${ports[1]}" &&
    _answers 127.0.0.3 "${ports[1]}" /master_discovery/list_masters "${ports[0]}" &&
    _answers 127.0.0.2 "${ports[0]}" /master_sync/get_sync_info &&
    _answers 127.0.0.3 "${ports[1]}" /master_sync/get_sync_info; } || verdict=1
  kill "${launches[@]}" 2>/dev/null || true
  wait "${launches[@]}" || true
  trap - EXIT
  return "$verdict"
}

_join() {  # ADDRESS MASTER_PORT PEER
  ROS_IP="$1" ROS_MASTER_URI="http://$1:$2" exec \
    roslaunch -p "$2" omron_ld90 multimaster.launch peer:="$3" rpc_port:="$(free_port)"
}

_answers() {  # ADDRESS MASTER_PORT SERVICE [WORD]: succeeds if the service answers within 30 s and the answer contains WORD
  local deadline=$((SECONDS + 30)) answer
  while kill -0 "${launches[@]}" 2>/dev/null && [ "$SECONDS" -lt "$deadline" ]; do
    answer="$(ROS_IP="$1" ROS_MASTER_URI="http://$1:$2" timeout 5 rosservice call "$3" 2>/dev/null)" || answer=''
    [ -z "$answer" ] || [[ "$answer" != *"${4:-}"* ]] || return 0
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
say "Joining two ROS masters on this machine once"
find_each_other || die "fkie multimaster was built, but two masters do not find each other: $(
  sed 's/\x1b[^m]*m//g' "$root/build/multimaster.log" | grep -m1 -E 'Error|Exception' || echo 'no error is reported') (whole log: $root/build/multimaster.log)"
say "fkie multimaster is ready; docs/how-to/multimaster.md says how to join two masters"
