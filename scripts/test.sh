#!/usr/bin/env bash
# Installs what is missing, builds, lints and runs every test; ends with "N passed, N failed, N skipped".
#
#   scripts/test.sh           everything, in minutes
#   scripts/test.sh --long    the same with long fuzzing
#   scripts/test.sh NAME...   only the system tests test/NAME.test
#
# Environment: LD90_REAL_MAPS, a folder with .map files of real robots; FKIE_ARCHIVE, sources of fkie multimaster (.tar.gz)
# where GitHub cannot be reached. What lies there is tested, too.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

system_tests=()
for arg in "$@"; do
  case "$arg" in
    -h | --help) sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    --long) export LD90_LONG_TESTS=1 ;;
    *) [ -f "$root/test/$arg.test" ] || die "there is no system test '$arg'; there are: $(cd "$root/test" && ls ./*.test | sed 's/.*\///; s/\.test$//' | paste -sd' ')"
       system_tests+=("$arg") ;;
  esac
done

if [ -n "${FKIE_ARCHIVE:-}" ]; then FKIE_ARCHIVE="$(realpath -m -- "$FKIE_ARCHIVE")"; fi
prepare "${run_packages[@]}" "${test_packages[@]}" "${multimaster_packages[@]}"
cd "$root"
results="$root/build/test_results"
rm -rf "$results"
mkdir -p "$results" "$root/build/artefacts"
export ROS_TEST_RESULTS_DIR="$results/ros" SYSTEM_TEST_ARTEFACTS="$root/build/artefacts"
export ROS_IP=127.0.0.1 ROS_HOME="$root/build/ros_home"
unset ROS_HOSTNAME DISPLAY

# record passed|failed|skipped NAME [REASON]
record() { printf '%s\t%s\t%s\n' "$1" "$2" "${3:-}" >>"$results/checks.tsv"; }

check() {  # check NAME COMMAND...: a command whose exit status is the result
  local name="$1" log="$results/$1.log"; shift
  if "$@" >"$log" 2>&1; then record passed "$name"; else record failed "$name" "see $log"; cat "$log"; fi
}

# virtual_environment NAME PYTHON PIP_ARGS...: build/NAME with these packages, made again when they change
virtual_environment() {
  local folder="$root/build/$1" python="$2"; shift 2
  local wanted; wanted="$("$python" --version) $* $(cat scripts/requirements-focal.txt)"
  [ "$(cat "$folder/.wanted" 2>/dev/null)" != "$wanted" ] || return 0
  rm -rf "$folder"
  "$python" -m venv "$folder" >>"$results/pip.log" 2>&1 &&
    "$folder/bin/python" -m pip install -q --only-binary :all: --disable-pip-version-check "$@" >>"$results/pip.log" 2>&1 &&
    echo "$wanted" >"$folder/.wanted"
}

find_python38() {
  local candidate
  for candidate in python3.8 "${HOME:-/root}"/.pyenv/versions/3.8*/bin/python3.8; do
    if "$candidate" -c '' 2>/dev/null; then echo "$candidate"; return; fi
  done
}

lint() {
  say "Lint"
  check catkin_lint catkin_lint --strict -W1 $(for package in src/*/package.xml; do dirname "$package"; done)
  if virtual_environment ruff /usr/bin/python3 ruff==0.14.5; then
    check ruff build/ruff/bin/ruff check .
  else
    record skipped ruff "it could not be installed from PyPI (offline?): see $results/pip.log"
  fi
}

unit_tests() {  # under both Pythons at once, for the sake of time
  local log38="$results/unit38.log"
  unit_tests_of_python38 >"$log38" 2>&1 &
  local other=$!
  say "Unit tests, $(/usr/bin/python3 --version)"
  /usr/bin/python3 -m pytest -q --junitxml="$results/unit.xml" src || true
  [ -f "$results/unit.xml" ] || record failed unit-tests "pytest did not finish"
  wait "$other"
  cat "$log38"
}

unit_tests_of_python38() {
  if [ "$(/usr/bin/python3 -c 'import sys; print(sys.version_info[:2])')" = '(3, 8)' ]; then return; fi
  local python38; python38="$(find_python38)"
  if [ -z "$python38" ]; then
    record skipped python3.8 "no Python 3.8 on this machine"
  elif ! virtual_environment python3.8 "$python38" -r scripts/requirements-focal.txt; then
    record skipped python3.8 "its packages could not be installed from PyPI (offline?): see $results/pip.log"
  else
    say "Unit tests without ROS, Python 3.8 and the library versions of Ubuntu 20.04"
    # nothing of this system's ROS may be found
    env -u LD90_LONG_TESTS PYTHONPATH="$(printf '%s:' src/*/src)" \
      build/python3.8/bin/python -m pytest -q --junitxml="$results/unit38.xml" \
      --ignore-glob='*/test/nodes/*' src || true
    [ -f "$results/unit38.xml" ] || record failed unit-tests-python3.8 "pytest did not finish"
  fi
}

# provide_multimaster: fkie multimaster in this environment, in a workspace of its own (build/multimaster, kept between
# runs) unless scripts/multimaster.sh has put it into this one. Where it cannot be had, the test says why.
provide_multimaster() {
  ! rospack find fkie_master_sync >/dev/null 2>&1 || return 0
  local workspace="$root/build/multimaster" log="$results/multimaster_build.log" made_of
  made_of="$root $(sha256sum <catkin_ws.repos)"  # a build says where it is, so it does not move with the folder
  if [ "$(cat "$workspace/.made_of" 2>/dev/null)" != "$made_of" ]; then
    say "Building fkie multimaster in build/multimaster"
    rm -rf "$workspace"
    mkdir -p "$workspace/src"
    MULTIMASTER_MISSING="$(import_multimaster "$workspace/src/multimaster_fkie" 2>&1 | tail -1)" || true
    export MULTIMASTER_MISSING
    [ -d "$workspace/src/multimaster_fkie" ] || return 0
    if ! catkin_make -C "$workspace" -DPYTHON_EXECUTABLE=/usr/bin/python3 >"$log" 2>&1; then
      record failed build-of-multimaster "see $log"
      MULTIMASTER_MISSING="it could not be built"
      return 0
    fi
    echo "$made_of" >"$workspace/.made_of"
  fi
  _source "$workspace/devel/setup.bash"
}

system_test() {  # one rostest on free ports, under its own ROS master
  local name="$1" log="$results/$1.log" begun=$SECONDS
  export LD90_ARCL_PORT LD90_OUTGOING_PORT SYSTEM_TEST_SKIPS="$results/$name.skips"
  LD90_ARCL_PORT="$(free_port)" LD90_OUTGOING_PORT="$(free_port)"
  local verdict=passed
  timeout --kill-after=20 600 rostest --pkgdir="$root/src/omron_ld90" --package=omron_ld90 \
    "$root/test/$name.test" >"$log" 2>&1 || verdict=failed
  [ ! -s "$SYSTEM_TEST_SKIPS" ] || verdict="$verdict, some skipped"
  say "  $name: $verdict ($((SECONDS - begun)) s)"
  case "$verdict" in failed*) tail -40 "$log"; record failed "$name" "see $log" ;; esac
}

run_system_tests() {
  say "System tests (rostest)"
    if [ ${#system_tests[@]} = 0 ]; then
    local file
    for file in test/*.test; do system_tests+=("$(basename "$file" .test)"); done
  fi
  case " ${system_tests[*]}" in *' multimaster'*) provide_multimaster ;; esac
  local name
  export PYTHONPATH="$root/test:$PYTHONPATH"
  for name in "${system_tests[@]}"; do system_test "$name"; done
}

if [ ${#system_tests[@]} = 0 ]; then
  lint
  unit_tests
fi
run_system_tests
/usr/bin/python3 scripts/count_results.py "$results"
