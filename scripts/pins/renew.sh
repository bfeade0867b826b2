#!/usr/bin/env bash
# Writes scripts/pins/NAME.txt anew: for the packages in NAME.in and all that they need, the hashes of their files on PyPI, for
# Python 3.8 to 3.13. Needs uv and a network. A test finds a download that is in no file of this folder.
#
#   scripts/pins/renew.sh NAME...
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
[ $# -gt 0 ] || { sed -n '2,5s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 1; }
for name in "$@"; do
  options=(--universal --python-version 3.8)
  case "$name" in
    python3.8) options=(--python-version 3.8 --python-platform linux) ;;
    vda5050_sdk) options=(--python-version 3.11 --no-deps) ;;
    vda5050_master) options=(--universal --python-version 3.10) ;;
    axe) options+=(--no-deps) ;;
  esac
  # Debian 12's pip refuses a package that another one requires with an extra, if its pin lacks the extra.
  uv pip compile --quiet --generate-hashes --no-strip-extras --no-header --no-annotate "${options[@]}" "$name.in" --output-file "$name.txt"
done
