#!/usr/bin/env bash
# Runs the unit tests and prints how much of the packages' code they cover; fails if it is less than the minimum below.
#
#   scripts/coverage.sh [PYTEST_ARGUMENT...]
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

floor=85  # percent of all lines and branches; lines that only system tests run (nodes, launch) do not count as run

prepare "${run_packages[@]}" "${test_packages[@]}"
cd "$root"
virtual_environment coverage /usr/bin/python3 --system-site-packages || die "pytest-cov could not be installed from PyPI: see build/pip.log"
jobs="${TEST_JOBS:-$(nproc)}"
export ROS_IP=127.0.0.1 ROS_HOME="$root/build/ros_home" COVERAGE_FILE="$root/build/coverage/data"
sources=()
for folder in src/*/src; do sources+=("--cov=$folder"); done
exec build/coverage/bin/python -m pytest -q -o cache_dir="$root/build/coverage/cache" -n "$jobs" --dist loadfile src \
  "${sources[@]}" --cov-branch --cov-report=html:build/coverage/html --cov-report=term --cov-fail-under="$floor" "$@"
