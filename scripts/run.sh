#!/usr/bin/env bash
# Installs missing packages, builds the workspace, and launches the full stack for a simulated or a real LD-90.
#
#   scripts/run.sh                                    simulated robot on maps/lab.map, RViz if there is a display
#   scripts/run.sh map_file:=my.map sim_speed:=2      any argument of launch/full_stack.launch
#   scripts/run.sh sim:=false robot_ip:=10.0.0.5 password_file:=secret.txt
#   scripts/run.sh vda5050:=true                      driven by a VDA 5050 master, over MQTT on 127.0.0.1:18830
#                                                     (settings for masters: docs/how-to/vda5050_masters.md)
#   scripts/run.sh sim:=false ... multimaster:=true peer:=10.0.0.9    the fleet manager is on another computer
#   scripts/run.sh fleet:=4 longest_edge:=1.5 demo:=true    4 simulated LD-90s, 4 AGVs, and their fleet manager
#   scripts/run.sh fleet:=4 work:=true                they pass doors, and hand pallets over at stations
#   scripts/run.sh fleet:=fleet.yaml                  the robots of a fleet file, real and simulated; --print prints all files
#
# Instead of password_file:=, you can put the real robot's password into the environment variable OMRON_LD90_PASSWORD.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

if [ "${1:-}" = -h ] || [ "${1:-}" = --help ]; then
  sed -n '2,14s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
  echo
  echo 'Arguments of launch/full_stack.launch:'
  sed -n 's/.*<arg name="\([^"]*\)".*doc="\([^"]*\)".*/  \1:=  \2/p' "$root/launch/full_stack.launch"
  echo
  echo 'With fleet:=, these arguments instead:'
  /usr/bin/python3 -I -c 'import sys; sys.path.insert(0, sys.argv[1]); from fleet_bringup.options import help_text; print(help_text())' \
    "$root/src/fleet_bringup/src"
  exit 0
fi

[ -z "${ROS_NAMESPACE:-}" ] ||
  die "ROS_NAMESPACE is $ROS_NAMESPACE in this shell, so neither a fleet manager nor the tools of RViz would reach the robot: unset ROS_NAMESPACE."
need_localhost
[ -n "${ROS_IP:-}${ROS_HOSTNAME:-}" ] || getent hosts "$(uname -n)" >/dev/null ||
  say "This computer's own name, $(uname -n), has no address, so commands in other terminals would not be heard: run 'export ROS_IP=127.0.0.1' there, or add the line '127.0.1.1 $(uname -n)' to /etc/hosts"

# master_listens: fails if no program listens at ROS_MASTER_URI. The tools of ROS would need half a second to find this out.
master_listens() {
  [[ "${ROS_MASTER_URI:-http://localhost:11311}" =~ ^http://([^/:]+):([0-9]+)/?$ ]] || return 0  # the tools judge it
  timeout 10 bash -c 'exec 3<>"/dev/tcp/$0/$1"' "${BASH_REMATCH[@]:1:2}" 2>/dev/null
}

# refuse_what_runs LAUNCH...: fails if one of the launch's nodes already runs. Under one ROS master, two launches with nodes of
# the same names would end each other's nodes for ever.
refuse_what_runs() {
  local node running
  master_listens || return 0
  running="$(timeout 10 rosnode list 2>/dev/null | sort)" || return 0
  for node in $(comm -12 - <(roslaunch --nodes "$@" 2>/dev/null | sort) <<<"$running"); do
    ! timeout 5 rosnode ping -c 1 "$node" 2>/dev/null | grep -q 'xmlrpc reply' ||
      die "$node runs under this ROS master already, and would lose its name to this run: end the running launch, or give this run a master and ports of its own (docs/how-to/troubleshooting.md)."
  done
}

# start_fleet ARGUMENT...: makes the launch and RViz files of a fleet in a folder, launches them, and removes the folder when
# the launch has ended.
start_fleet() {
  prepare "${run_packages[@]}"
  case " $* " in *' --print '*) exec rosrun fleet_bringup fleet_launch "$@" ;; esac
  local launch
  launch="$(rosrun fleet_bringup fleet_launch "$@")" || exit 1
  (trap '' INT TERM HUP; tail -s 0.5 -f --pid=$$ /dev/null; rm -rf "$(dirname "$launch")") </dev/null >/dev/null 2>&1 &
  if grep -q 'name="multimaster" value="true"' "$launch"; then
    [ -n "${ROS_IP:-}" ] || die "robots of this fleet have computers of their own: set and export ROS_IP, the address at which they reach this computer."
  # If all robots are simulated, no other computer needs to reach the nodes.
  elif ! grep '"robot_ip"' "$launch" | grep -qv '"127.0.0.1"'; then
    export ROS_IP="${ROS_IP:-127.0.0.1}"
  fi
  unset OMRON_LD90_PASSWORD
  refuse_what_runs "$launch"
  keep_private
  say "Starting: roslaunch $(printf '%q' "$launch")"
  exec rosrun fleet_bringup start_output "$launch"
}

# limit_files: sets the limit of open files, high enough for every fleet, and low enough for roscpp, which reserves memory for
# each file that may be open. In some containers the limit is a thousand million, which would take gigabytes per node.
limit_files() { ulimit -Sn 16384 2>/dev/null || ulimit -Sn "$(ulimit -Hn)"; }
limit_files

# keep_private: lets only this user read journals, records and logs. roslaunch gives folders of logs the mode of ROS_HOME.
keep_private() { umask 077; mkdir -p "${ROS_HOME:-$HOME/.ros}"; }

for arg in "$@"; do
  case "$arg" in fleet:=*) start_fleet "$@" ;; esac
done

declare -A given=([robot_name]=omron_ld90 [sim]=true [arcl_port]=7171 [outgoing_port]=7179)
args=()
for arg in "$@"; do
  case "$arg" in
    *:=*) ;;
    *) die "'$arg' is not of the form name:=value; see scripts/run.sh --help" ;;
  esac
  name="${arg%%:=*}" value="${arg#*:=}"
  grep -q "<arg name=\"$name\"" "$root/launch/full_stack.launch" ||
    die "there is no argument '$name'; scripts/run.sh --help lists them"
  case "$name" in
    # Nodes run in another folder, so file names are made absolute here. The shell does not expand ~ after :=.
    *_file | *_map | *_config) [ -z "$value" ] || value="$(realpath -m -- "${value/#\~\//$HOME/}")" ;;
  esac
  given[$name]="$value"
  args+=("$name:=$value")
done
for name in map_file base_map graph_file password_file mqtt_credentials_file mqtt_ca_file; do
  [ "$name" = map_file ] && [ -n "${given[base_map]:-}" ] && continue  # the map is made from base_map
  [ -z "${given[$name]:-}" ] || [ -r "${given[$name]}" ] ||
    die "$name:=${given[$name]} cannot be read; check its name and its permissions"
done
for name in arcl_port outgoing_port; do
  [[ "${given[$name]}" =~ ^[1-9][0-9]{0,4}$ ]] && [ "${given[$name]}" -le 65535 ] ||
    die "$name:=${given[$name]} is not a TCP port, a number from 1 to 65535"
done

is_true() { [[ "${1,,}" =~ ^(true|1)$ ]]; }
if is_true "${given[multimaster]:-}"; then
  [ -n "${given[peer]:-}" ] || die "multimaster:=true needs peer:=ADDRESS, the address of the fleet manager's computer."
  for name in fleet_manager vda5050; do
    ! is_true "${given[$name]:-}" ||
      die "multimaster:=true takes missions from the fleet manager at ${given[peer]}, so $name:=true would be a second master of the robot: choose one."
  done
fi
if is_true "${given[vda5050]:-}"; then
  ! is_true "${given[fleet_manager]:-}" ||
    die "vda5050:=true and fleet_manager:=true are two masters of one robot: choose one."
fi

prepare "${run_packages[@]}"

# From here on Python is installed on every machine.
if is_true "${given[multimaster]:-}"; then
  [ -n "${ROS_IP:-}" ] || ROS_IP="$(address_towards "${given[peer]}")" ||
    die "there is no network route to peer:=${given[peer]}: check that it is the address of the fleet manager's computer, and that the network is up."
  export ROS_IP
fi
if is_true "${given[vda5050]:-}" && [ -z "${given[mqtt_broker]:-}" ]; then
  port_is_free 18830 ||
    die "TCP port 18830 is in use, so the embedded MQTT broker cannot use it: end the program that uses it, or name a broker with mqtt_broker:=HOST:PORT."
fi
refuse_what_runs omron_ld90 full_stack.launch ${args[@]+"${args[@]}"}
case "${given[sim],,}" in
  true | 1)
    export ROS_IP="${ROS_IP:-127.0.0.1}"
    for name in arcl_port outgoing_port; do
      port_is_free "${given[$name]}" ||
        die "TCP port ${given[$name]} is in use, so the simulated robot cannot use it: end the program that uses it, or choose another with $name:=PORT."
    done ;;
esac
# If DISPLAY names a display that cannot be opened, rviz_view reports it, and everything else runs.
if [ -z "${DISPLAY:-}" ] && [ -z "${given[rviz]:-}" ]; then
  say "No display: RViz is not started. Use rostopic, or RViz on another machine, to see the robot"
fi

# roslaunch writes its whole environment into its log. So the password is passed on in a file that only this user can read.
# The file is removed when the launch has ended.
if [ -n "${OMRON_LD90_PASSWORD:-}" ] && [ -z "${given[password_file]:-}" ] && [[ "${given[sim],,}" =~ ^(false|0)$ ]]; then
  file="$(umask 077 && mktemp "${XDG_RUNTIME_DIR:-${TMPDIR:-/tmp}}/ld90_password.XXXXXX")"
  (trap '' INT TERM HUP; tail -s 0.5 -f --pid=$$ /dev/null; rm -f "$file") </dev/null >/dev/null 2>&1 &
  printf '%s' "$OMRON_LD90_PASSWORD" >"$file"
  args+=("password_file:=$file")
fi
unset OMRON_LD90_PASSWORD

keep_private
say "Starting: roslaunch omron_ld90 full_stack.launch$([ ${#args[@]} = 0 ] || printf ' %q' "${args[@]}")"
exec rosrun fleet_bringup start_output omron_ld90 full_stack.launch ${args[@]+"${args[@]}"}
