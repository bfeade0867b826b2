# Replaces scripts/common.sh in an installed workspace: there is nothing to install or to build. This file is sourced, never run.

run_packages=()
full_stack=(roslaunch omron_ld90 full_stack.launch)

say() { printf '== %s\n' "$*"; }
die() { printf '\nCannot go on: %s\n' "$*" >&2; exit 1; }
prepare() {
  command -v roslaunch >/dev/null && rospack find omron_ld90 >/dev/null 2>&1 ||
    die "the installed packages are not in this shell's environment: source the setup.bash of the install space (with Debian packages none is needed)"
}
python_module() {  # python_module MODULE ARGUMENT...: nothing is imported from the working directory
  (cd / && /usr/bin/python3 -m "$@")
}
