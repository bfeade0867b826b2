#!/usr/bin/env bash
# Builds the documentation site from docs/ in build/site; fails on any warning, such as a broken link.
#
#   scripts/docs.sh     then open build/site/index.html, which needs neither a web server nor a network
#
# Exit status: 0 built; 1 a page has an error, or mkdocs could not be installed from PyPI.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

case "${1:-}" in
  '') ;;
  -h | --help) sed -n '2,6s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
  *) die "scripts/docs.sh takes no argument, not '$1'" ;;
esac

mkdir -p "$root/build"
install_missing 1 "python3-venv python3-venv"
virtual_environment mkdocs /usr/bin/python3 ||
  die "mkdocs could not be installed from PyPI (offline?): see build/pip.log"
cd "$root"
# --quiet would also hide warnings from --strict
NO_MKDOCS_2_WARNING=1 build/mkdocs/bin/mkdocs build --strict
say "The site is build/site/index.html"
