#!/usr/bin/env bash
# Builds wheels and sdists of the libraries that need no ROS: build/dist/*.whl and *.tar.gz. A library is built anew if a file of it
# has changed.
#
#   scripts/make_wheels.sh                       builds them
#   scripts/make_wheels.sh python3.8 python3.12  then, for each of these Pythons, installs both kinds, with dependencies from PyPI
#                                                of known hashes, and drives a simulated robot with them without ROS
#
# Exit status: 0 success; 1 the build or the installation failed, or the robot did not arrive.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

case "${1:-}" in
  -h | --help) sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
  -*) die "unknown option $1: see scripts/make_wheels.sh --help" ;;
esac

here="$root/build/dist" log="$root/build/wheels.log"
mkdir -p "$root/build"
: >"$log"
install_missing 1 "python3-venv python3-venv"
virtual_environment wheels /usr/bin/python3 --system-site-packages ||
  die "build and setuptools could not be installed from PyPI (offline?): see build/pip.log"
sources="$root/build/wheel_sources" keys="$root/build/wheel_keys"  # for each library, the hashes of its sources
mkdir -p "$here" "$keys"
for library in "${pure_libraries[@]}"; do
  key="$(cd "$root" && find "src/$library" scripts/pins/wheels.txt scripts/make_wheels.sh -type f -not -name '*.pyc' -print0 |
    LC_ALL=C sort -z | xargs -0 sha256sum)"
  built=("$here/$library"-[0-9]*)
  if [ "${#built[@]}" = 2 ] && [ "$key" = "$(cat "$keys/$library" 2>/dev/null)" ]; then continue; fi
  rm -rf "$sources" "${built[@]}"
  mkdir "$sources"
  cp -r "$root/src/$library" "$sources"  # a copy, because building leaves files beside the sources
  # the check of dependencies would start two more programs; scripts/pins/wheels.txt lists all dependencies
  "$root/build/wheels/bin/python" -I -m build --no-isolation --skip-dependency-check --outdir "$here" "$sources/$library" >>"$log" 2>&1 ||
    die "$library was not built: see $log"
  echo "$key" >"$keys/$library"
done
rm -rf "$sources"
for file in "$here"/*-[0-9]*; do  # of a library that does not exist any more
  library="$(basename "$file")"
  [[ " ${pure_libraries[*]} " = *" ${library%%-*} "* ]] || rm "$file"
done
say "Built:" "$here"/*

# drive ENVIRONMENT: starts the installed simulated robot, and drives it with a client that uses the installed library
drive() {
  local port sim
  port="$(free_port)"
  (cd / && exec "$1/bin/ld90_sim" --map "$root/maps/lab.map" --port "$port" --password adept --speed 10) >>"$log" 2>&1 &
  sim=$!
  until "$1/bin/python" -I -c "import socket; socket.create_connection(('127.0.0.1', $port))" 2>/dev/null; do
    kill -0 $sim || return 1
  done
  (cd / && timeout 60 "$1/bin/python" "$root/examples/drive_without_ros.py" --port "$port" 127.0.0.1 12 <<<adept)
  local result=$?
  kill $sim
  wait $sim 2>/dev/null || true
  return $result
}

unset PYTHONPATH
for python in "$@"; do
  for kind in whl tar.gz; do
    environment="$here/$(basename "$python")_$kind"
    say "$("$python" --version), from .$kind files"
    "$python" -I -m venv "$environment" &&
      "$environment/bin/python" -I -m pip install -q --disable-pip-version-check --require-hashes --only-binary :all: \
        -r "$root/scripts/pins/wheels.txt" -r "$root/scripts/pins/wheels_run.txt" >>"$log" 2>&1 &&
      "$environment/bin/python" -I -m pip install -q --disable-pip-version-check --no-index --no-build-isolation \
        "$here"/*."$kind" >>"$log" 2>&1 &&
      "$environment/bin/python" -I -m pip check >>"$log" 2>&1 ||
      die "the .$kind files could not be installed with $python: see $log"
    "$environment/bin/ld_map" info "$root/maps/lab.map" >/dev/null || die "ld_map does not run"
    drive "$environment" || die "the robot did not arrive: see $log"
  done
done
