#!/usr/bin/env bash
# Runs tests of a built workspace, one after the other, and writes JUnit files into a folder. scripts/test.sh and
# `catkin_make run_tests` call it; people call scripts/test.sh. TEST_JOBS=2 runs two tests at a time.
#
#   run_tests.sh RESULTS unit             the unit tests
#   run_tests.sh RESULTS python3.8        tests of imports and properties without ROS under Python 3.8, if it is
#                                         installed; with LD90_LONG_TESTS=1 every unit test without ROS
#   run_tests.sh RESULTS system NAME...   the system tests test/NAME.test, each under its own ROS master
#   run_tests.sh RESULTS once-more        runs tests again, alone, that failed while other tests ran: at most three of each
#                                         kind. The second result counts; the summary names these tests
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

[ $# -ge 2 ] || { sed -n '2,10s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 1; }
results="$1" kind="$2"; shift 2
cd "$root"
export PATH="$root/devel/bin:/usr/bin:$PATH"  # the workspace's ROS master, and ROS's python3
mkdir -p "$results" build/artefacts
export SYSTEM_TEST_ARTEFACTS="$root/build/artefacts" ROS_IP=127.0.0.1 ROS_HOME="$root/build/ros_home"
unset ROS_HOSTNAME DISPLAY
# Without a folder for compiled modules, each of hundreds of processes would compile them again.
unset PYTHONDONTWRITEBYTECODE
export PYTHONPYCACHEPREFIX="$root/build/pycache"
if [ -n "${FKIE_ARCHIVE:-}" ]; then FKIE_ARCHIVE="$(realpath -m -- "$FKIE_ARCHIVE")"; fi

jobs="${TEST_JOBS:-1}"

unit_pytest() {  # unit_pytest OPTION...
  /usr/bin/python3 -m pytest -q -o cache_dir="$results/cache/unit" src "$@"
}

python38_pytest() {  # python38_pytest OPTION...: without this system's ROS, and without real maps (one Python tests them)
  local selection=() files=(src)
  if [ -z "${LD90_LONG_TESTS:-}" ]; then  # pytest reads only these files: to read all would take longer than to run these tests
    selection=(-m 'hypothesis or every_python')
    mapfile -t files < <(grep -rlE --include='test_*.py' 'hypothesis|every_python|[.]TestCase' src | grep -v /test/nodes/)
  fi
  env -u LD90_LONG_TESTS -u LD90_REAL_MAPS HYPOTHESIS_PROFILE=compatibility PYTHONPATH="$(printf '%s\n' "$root"/src/*/src | paste -sd:)" \
    build/python3.8/bin/python -m pytest -q -o cache_dir="$results/cache/python38" \
    --ignore-glob='*/test/nodes/*' ${selection[@]+"${selection[@]}"} "${files[@]}" "$@"
}

unit_tests() {
  say "Unit tests, $(/usr/bin/python3 --version)"
  local beside=()
  [ "$jobs" -le 1 ] || beside=(-n $((jobs + 1)) --dist loadfile)
  unit_pytest ${beside[@]+"${beside[@]}"} --junitxml="$results/unit.xml" || true
  [ -f "$results/unit.xml" ] || record "$results" failed unit-tests "pytest did not finish"
}

find_python38() {
  local candidate
  for candidate in python3.8 "${HOME:-/root}"/.pyenv/versions/3.8*/bin/python3.8; do
    if "$candidate" -I -c '' 2>/dev/null; then echo "$candidate"; return; fi
  done
}

unit_tests_of_python38() {
  if [ "$(/usr/bin/python3 -I -c 'import sys; print(sys.version_info[:2])')" = '(3, 8)' ]; then return; fi
  local python38; python38="$(find_python38)"
  if [ -z "$python38" ]; then
    record "$results" skipped python3.8 "no Python 3.8 on this machine"
  elif ! virtual_environment python3.8 "$python38" --no-binary paho-mqtt --no-build-isolation; then
    record "$results" skipped python3.8 "its packages could not be installed from PyPI (offline?): see build/pip.log"
  else
    say "Tests without ROS, Python 3.8 and the library versions of Ubuntu 20.04"
    python38_pytest --junitxml="$results/python38.xml" || true
    [ -f "$results/python38.xml" ] || record "$results" failed unit-tests-python3.8 "pytest did not finish"
  fi
}

failed_units_once_more() {  # runs failed unit tests again: other tests may have taken the CPU time that they needed
  local suite failed
  for suite in unit python38; do
    failed="$(/usr/bin/python3 scripts/test_results.py failed "$results/$suite.xml" 2>/dev/null)" || continue
    if [ "$failed" -ge 1 ] && [ "$failed" -le 3 ]; then
      say "$failed unit tests failed beside others. They run once more, alone, and the second result counts"
      "${suite}_pytest" --last-failed --junitxml="$results/$suite.again.xml" || true
      [ ! -f "$results/$suite.again.xml" ] ||
        /usr/bin/python3 scripts/test_results.py once-more "$results/$suite.xml" "$results/$suite.again.xml"
    fi
  done
}

prepare_system_tests() {  # prepare_system_tests NAME...: installs what these tests need, and makes their helpers importable
  case " $*" in *' multimaster'*) join_masters_for_tests ;; esac
  case " $* " in *' vda5050 '*) provide_vda5050_schemas ;; esac
  export PYTHONPATH="$root/test${PYTHONPATH:+:$PYTHONPATH}"
}

join_masters_for_tests() {  # with fkie multimaster if it is available; the summary names the program that joined them
  provide_multimaster || record "$results" failed build-of-multimaster "see build/multimaster_build.log"
  if rospack find fkie_master_sync >/dev/null 2>&1; then
    echo "ROS masters were joined by fkie multimaster"
  else
    echo "ROS masters were joined by test/master_mirror.py, because fkie multimaster is not available: ${MULTIMASTER_MISSING:-run scripts/multimaster.sh once}"
  fi >"$results/multimaster.note"
}

system_test() {  # system_test NAME ARCL_PORT OUTGOING_PORT: one rostest on free ports, under its own ROS master
  local name="$1" log="$results/$1.log" begun=$SECONDS verdict=passed file
  export LD90_ARCL_PORT="$2" LD90_OUTGOING_PORT="$3" ROS_TEST_RESULTS_DIR="$results/ros/$name"
  # Tests that run at the same time use the same robot names, so each test needs its own folder for the files that robots keep.
  export ROS_HOME="$root/build/ros_home/$name" ROS_LOG_DIR="$root/build/ros_home/$name/log"  # a test may change ROS_HOME
  rm -rf "$ROS_HOME"
  mkdir -p "$ROS_HOME"
  timeout --kill-after=20 "${LD90_LONG_TESTS:+1}600" ${mounts_alone[@]+"${mounts_alone[@]}"} rostest --pkgdir="$root/src/omron_ld90" --package=omron_ld90 \
    "$root/test/$name.test" >"$log" 2>&1 &
  local rostest=$!
  trap 'kill -TERM $rostest; wait $rostest' TERM
  wait $rostest || verdict=failed
  for file in "$ROS_TEST_RESULTS_DIR"/omron_ld90/*.xml; do
    [ ! -f "$file" ] || mv "$file" "$results"
  done
  if grep -q '<skipped' "$results/rosunit-$name.xml" 2>/dev/null; then verdict="$verdict, some skipped"; fi
  times >"$log.times"  # its second line has the processor time of all programs of this test
  say "  $name: $verdict ($((SECONDS - begun)) s, $(awk -F'[ms ]+' 'NR == 2 {printf "%.0f", 60 * ($1 + $3) + $2 + $4}' "$log.times") s of a processor)"
  rm "$log.times"
  echo "$((SECONDS - begun)) $name" >>"$results/system_tests.seconds"
  case "$verdict" in
    failed*)
      tail -120 "$log"
      grep -qE '<(failure|error)' "$results"/ros{unit,test}-*"$name.xml" ||
        record "$results" failed "$name" "see $log"
      echo "$name" >>"$results/failed" ;;
  esac
}

# In a separate mount namespace, the mounts of a test disappear with the test, even if it is killed.
mounts_alone=()
! unshare --mount true 2>/dev/null || mounts_alone=(unshare --mount env LD90_MOUNTS_ALONE=1)

known="$root/build/system_tests.seconds"

system_tests() {  # TEST_JOBS tests at a time, the longest first, according to the last run or to their time limits
  local name running=0
  rm -f "$results/failed"
  prepare_system_tests "$@"
  touch "$known"
  set -- $(/usr/bin/python3 scripts/test_results.py longest-first "$known" "$@")
  trap 'kill -TERM $(jobs -p); wait; exit 130' INT TERM  # the tests end when the script is ended
  for name in "$@"; do
    if [ "$running" -ge "$jobs" ]; then wait -n || true; running=$((running - 1)); fi
    system_test "$name" "$(free_port)" "$(free_port)" &
    running=$((running + 1))
  done
  wait
  [ "$jobs" -gt 1 ] && [ $# -gt 1 ] || rm -f "$results/failed"  # no other tests ran beside them
  keep_seconds
}

keep_seconds() {  # keeps the durations of this run, and earlier durations of tests that did not run now
  rm -rf "$results/ros"
  cp "$results/system_tests.seconds" "$known.new"
  awk '{print $2}' "$known.new" | grep -vwFf - "$known" >>"$known.new" || true
  mv "$known.new" "$known"
}

failed_system_tests_once_more() {
  local name failed; [ -f "$results/failed" ] || return 0
  mapfile -t failed <"$results/failed"
  rm "$results/failed"
  [ ${#failed[@]} -le 3 ] || return 0
  prepare_system_tests "${failed[@]}"
  for name in "${failed[@]}"; do
    say "$name failed beside other tests. It runs once more, alone, and the second result counts"
    mv "$results/$name.log" "$results/$name.first_try.log"
    rm -rf "$root/build/ros_home/$name.first_try"
    mv "$root/build/ros_home/$name" "$root/build/ros_home/$name.first_try"
    rm -f "$results"/ros{unit,test}-*"$name.xml" "$results/check-$name.xml"
    echo "system test $name failed beside another one, and ran once more, alone" >>"$results/once_more.note"
    (system_test "$name" "$(free_port)" "$(free_port)")
  done
  keep_seconds
}

case "$kind" in
  unit) provide_vda5050_schemas; provide_vda5050_master; provide_z3; unit_tests ;;
  python3.8) unit_tests_of_python38 ;;
  system) system_tests "$@" ;;
  once-more) failed_units_once_more; failed_system_tests_once_more ;;
  *) die "there are no tests '$kind'; choose from: unit, python3.8, system, once-more" ;;
esac
