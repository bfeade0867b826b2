#!/usr/bin/env bash
# Builds packages of this workspace for the running Debian (12 or 13), and checks them with lintian.
#
#   scripts/make_deb.sh            the packages are build/deb/*.deb
#   scripts/make_deb.sh --try      then installs them in a bare system of the same Debian (build/deb/root) and drives a simulated
#                                  robot there; needs root rights and a network
#
# Exit status: 0 success; 1 the build failed, lintian found an error, or the robot did not drive.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

case "${1:-}" in
  '' | --try) ;;
  *) sed -n '2,8s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; [ "$1" = -h ] || [ "$1" = --help ]; exit ;;
esac
case "$(operating_system)" in
  'debian 12' | 'debian 13') release="$(. /etc/os-release; echo "$VERSION_CODENAME")" ;;
  *) die "the packages depend on those of Debian 12 or 13; this is $(operating_system)." ;;
esac

install_missing 1 "${run_packages[@]}" "${deb_packages[@]}"
here="$root/build/deb" log="$root/build/deb.log"
rm -rf "$here/source" "$here"/*.deb
mkdir -p "$here/source"
(cd "$root" && cp -a CHANGELOG.md LICENSE README.md docs examples launch maps rviz src "$here/source")
find "$here/source" \( -name __pycache__ -o -name '*.egg-info' \) -prune -exec rm -rf {} +
rm -f "$here/source/src/CMakeLists.txt"
/usr/bin/python3 "$root/scripts/debian_files.py" "$here/source" "$(printf '%s\n' "${run_packages[@]}" "${multimaster_packages[@]}")"
say "Building Debian packages"
(cd "$here/source" && PATH=/usr/bin:/bin:/usr/sbin:/sbin env -u CMAKE_PREFIX_PATH -u ROS_PACKAGE_PATH -u PYTHONPATH \
  dpkg-buildpackage --build=binary --unsigned-source --unsigned-changes) >"$log" 2>&1 || {
  tail -20 "$log" >&2
  die "the packages were not built; the whole log is $log"
}
say "Checking them with lintian"
lintian --fail-on error --tag-display-limit 0 "$here"/*.changes
/usr/bin/python3 -I "$root/test/file_modes.py" "$here"/*.deb || die "files of the packages differ from the table in docs/explanation/security.md"
say "The packages:" "$here"/*.deb
[ "${1:-}" = --try ] || exit 0

# A folder with only Debian's base system, in which apt installs the packages as on a user's machine.
[ "$(id -u)" = 0 ] || die "only root can make the bare Debian system: run this as root."
install_missing 1 "debootstrap debootstrap" "iproute2 iproute2"
bare="$here/root"
if [ "$(cat "$bare/.bare" 2>/dev/null)" != "$release" ]; then
  say "Making a bare system of Debian's release $release: $bare"
  rm -rf "$bare"
  debootstrap --force-check-gpg --variant=minbase --include=ca-certificates "$release" "$bare" >>"$log" 2>&1 || die "debootstrap failed: see $log"
  echo "$release" >"$bare/.bare"
fi
rm -rf "$bare/debs" && mkdir "$bare/debs" && cp "$here"/*.deb "$bare/debs"
cp /etc/resolv.conf "$bare/etc/resolv.conf"
echo '127.0.0.1 localhost' >"$bare/etc/hosts"  # Debian's installer writes this file, debootstrap does not
mountpoint -q "$bare/proc" || mount -t proc proc "$bare/proc"
trap 'umount "$bare/proc"' EXIT
say "Installing the packages there"
inside() { chroot "$bare" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive "$@"; }
inside sh -ec 'apt-get update -q; apt-get install -y -q --no-install-recommends --reinstall /debs/*.deb' >>"$log" 2>&1 ||
  die "the packages could not be installed: see $log"
say "Driving a simulated robot there"
cp "$root/scripts/try_packages.sh" "$bare/tmp/"
# In a separate network namespace, the robot's nodes have no connection to ROS nodes on this machine.
unshare --net sh -c 'ip link set lo up; exec "$@"' - chroot "$bare" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root \
  timeout 600 bash -eu /tmp/try_packages.sh || die "the installed packages do not work"
say "Removing the packages"
inside sh -ec "apt-get purge -y -q \$(dpkg-query -f '\${source:Package} \${Package}\n' -W | awk '\$1 == \"omron-ld90\" {print \$2}')" >>"$log" 2>&1 ||
  die "the packages could not be removed: see $log"
