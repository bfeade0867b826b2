#!/usr/bin/env bash
# Makes a graph from a robot's map, converts both into a new map, and starts a robot on it. Prints the three commands.
#
#   scripts/new_site.sh site.map                         makes site_graph.yaml and site_fleet.map beside it, starts a simulated robot
#   scripts/new_site.sh site.map --no-start              only makes the two files
#   scripts/new_site.sh site.map --dock=-13.2,-7,180       any option of make_graph, written with =
#   scripts/new_site.sh site.map sim_speed:=2 rviz:=false  any argument of launch/full_stack.launch
#
# An edited site_graph.yaml is used unchanged. A ROS map (.yaml) has no .map file to convert: use make_graph.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

case "${1:-}" in
  '' | -h | --help) sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
esac
map="$(realpath -m -- "$1")"; shift
[ -r "$map" ] || die "$map cannot be read; check its name and its permissions"
case "$map" in
  *.map) ;;
  *) die "$map is not a .map file of a robot" ;;
esac
start=true launch_args=() make_options=()
for arg in "$@"; do
  case "$arg" in
    --no-start) start=false ;;
    --*=*) make_options+=("$arg") ;;
    *:=*) launch_args+=("$arg") ;;
    *) die "'$arg' is neither --no-start, nor of the form --name=value or name:=value" ;;
  esac
done
graph="${map%.map}_graph.yaml" made="${map%.map}_fleet.map"

picture="${graph%.yaml}.png"
is_own() { [ ! -e "$1" ] || grep -q "$2" -- "$1"; }  # is_own FILE MARK: there is no such file, or its program has written it
is_own "$made" omron_ros_map || die "$made was not made by this script and is not overwritten: move it, or give the map another name"
is_own "$picture" 'written by make_graph' || die "$picture was not made by this script and is not overwritten: move it, or give the map another name"

prepare "${run_packages[@]}"
commands=()
graph_value() { python_module graph_editor.graph_values "$@"; }
editor="roslaunch graph_editor edit.launch$(printf ' %q' "map_file:=$map" "graph_file:=$graph")"
do_and_note() { commands+=("$(printf '%q ' "$@")"); "$@"; }


if [ -e "$graph" ] && ! graph_value unedited "$graph"; then
  say "$graph was edited and is used as it is"
  do_and_note rosrun graph_editor check_graph --graph "$graph" --map "$map" ||
    die "the graph has errors: open it with $editor"
else
  say "Making $graph"
  do_and_note rosrun graph_editor make_graph --map "$map" --output "$graph" --draw "$picture" ${make_options[@]+"${make_options[@]}"}
fi
dock="$(graph_value dock "$graph")"
widths="$(graph_value edge_widths "$graph" "$map")"

say "Converting to $made"
convert=(rosrun omron_ld90 omron_ros_map --graph "$graph" --base-map "$map" --output "$made" --fences areas)
[ -z "$dock" ] || convert+=(--dock-vertex "$dock")
[ -z "$widths" ] || convert+=(--edge-width "$widths")
do_and_note "${convert[@]}"

run=("${full_stack[@]}" "map_file:=$made" "graph_file:=$graph" "dock_vertex:=${dock:-0}" ${launch_args[@]+"${launch_args[@]}"})
commands+=("$(printf '%q ' "${run[@]}")")
say "The three commands"
printf '  %s\n' "${commands[@]}"
say "Change the graph with: $editor"
[ "$start" = true ] || exit 0
exec "${run[@]}"
