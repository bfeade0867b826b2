#!/usr/bin/env bash
# Runs benchmarks and prints tables. Each figure is the median of several runs; its floor stands beside it.
#
#   scripts/bench.sh              all benchmarks
#   scripts/bench.sh TOPIC...     only these topics (scripts/bench/TOPIC.py)
#   scripts/bench.sh TOPIC --only PART   options go to the topic's program; its --help lists them
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

[ "${1:-}" != -h ] && [ "${1:-}" != --help ] || { sed -n '2,6s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0; }
topics=() options=()
while [ $# -gt 0 ] && [[ "$1" != -* ]]; do topics+=("$1"); shift; done
options+=("$@")
if [ ${#topics[@]} = 0 ]; then
  for file in "$root"/scripts/bench/*.py; do topics+=("$(basename "$file" .py)"); done
fi
for topic in "${topics[@]}"; do
  [ -f "$root/scripts/bench/$topic.py" ] ||
    die "there is no benchmark '$topic'; choose from: $(cd "$root/scripts/bench" && ls ./*.py | sed 's/.*\///; s/\.py$//' | paste -sd' ')"
done

prepare "${run_packages[@]}" "${test_packages[@]}" "${multimaster_packages[@]}"
case " ${topics[*]} " in *' multimaster '* | *' masters '*) provide_multimaster ;; esac
export ROS_IP=127.0.0.1 PYTHONPATH="$root/test:$PYTHONPATH"
cd "$root"
for topic in "${topics[@]}"; do
  say "Benchmark $topic, $(date +%F), $(nproc) x $(sed -n 's/^model name.*: //p' /proc/cpuinfo | head -1), $(/usr/bin/python3 --version)"
  /usr/bin/python3 "scripts/bench/$topic.py" "${options[@]}"
done
