#!/usr/bin/env bash
# Runs benchmarks and prints tables. Each figure is the median of several runs; its floor is beside it.
#
#   scripts/bench.sh all          each topic, the long ones shortened: about 55 minutes on two cores
#   scripts/bench.sh              each topic as a whole: many hours
#   scripts/bench.sh TOPIC...     only these topics (scripts/bench/TOPIC.py)
#   scripts/bench.sh TOPIC --only PART   options go to the topic's program; its --help lists them
#
# Exit status: 1 if a topic failed; the other topics still run.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

[ "${1:-}" != -h ] && [ "${1:-}" != --help ] || { sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0; }
declare -A shortened=(  # options of a topic in `all`
  [agreement]='--minutes 6 --virtual 6'
  [factory]='--only load'
  [fleet]='--only stations --only any_vertex --only conflict_sets --only sparse --only replanning'
  [load]='--only robots_200 --only planning --only decisions'
  [order]='--only laboratory --seeds 1'
  [scale]='--robots 50 --hosted true'
  [supervisor]='--only latency --only step --only acceptance --only load'
  [vda5050]='--only latency'
)
topics=() options=() is_short=''
while [ $# -gt 0 ] && [[ "$1" != -* ]]; do topics+=("$1"); shift; done
options+=("$@")
if [ "${topics[*]}" = all ]; then topics=() is_short=yes; fi
if [ ${#topics[@]} = 0 ]; then
  for file in "$root"/scripts/bench/*.py; do topics+=("$(basename "$file" .py)"); done
fi
for topic in "${topics[@]}"; do
  [ -f "$root/scripts/bench/$topic.py" ] ||
    die "there is no benchmark '$topic'; choose from: all $(cd "$root/scripts/bench" && ls ./*.py | sed 's/.*\///; s/\.py$//' | paste -sd' ')"
done

prepare "${run_packages[@]}" "${test_packages[@]}" "${multimaster_packages[@]}"
case " ${topics[*]} " in *' multimaster '* | *' masters '*) provide_multimaster ;; esac
export ROS_IP=127.0.0.1 PYTHONPATH="$root/test:$root/src/fleet_simulation/test${PYTHONPATH:+:$PYTHONPATH}"
cd "$root"
failed=()
for topic in "${topics[@]}"; do
  read -ra own <<<"${is_short:+${shortened[$topic]:-}}"
  say "Benchmark $topic ${own[*]-} ${options[*]-}, $(date +%F), $(nproc) x $(sed -n 's/^model name.*: //p' /proc/cpuinfo | head -1), $(/usr/bin/python3 --version)"
  begun=$SECONDS
  /usr/bin/python3 "scripts/bench/$topic.py" ${own[@]+"${own[@]}"} ${options[@]+"${options[@]}"} || failed+=("$topic")
  say "$topic took $((SECONDS - begun)) s"
done
[ ${#failed[@]} = 0 ] || die "these topics failed: ${failed[*]}"
