#!/bin/sh
# Makes this checkout ready: system packages, .venv, the locked Python packages, adc-bench itself.
# What is already there is left alone; a second run does nothing.
set -eu
cd "$(dirname "$0")/.."

missing() {
  printf 'error: this machine lacks something\n  where:      scripts/setup.sh\n  found:      %s\n  wanted:     %s\n  what to do: %s\n' \
    "$1" "$2" "$3" >&2
  exit 4
}

find_python() {  # the Pythons that every locked wheel exists for
  for name in python3 python3.13 python3.12 python3.11; do
    if "$name" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' 2>/dev/null; then
      echo "$name"
      return
    fi
  done
}

install_system_packages() {
  set -- $(sh scripts/system_packages.sh missing "$python")
  [ $# -gt 0 ] || return 0
  echo "setup: installing system packages: $*"
  if [ "$(id -u)" = 0 ]; then
    as_root=
  elif [ -t 0 ] && command -v sudo >/dev/null; then
    as_root=sudo
  elif sudo -n true 2>/dev/null; then
    as_root="sudo -n"
  else
    missing "no $*, and no right to install it" "the right to install system packages, once" \
      "as root: cd $(pwd) && sh scripts/system_packages.sh install $*"
  fi
  $as_root sh scripts/system_packages.sh install "$@"
}

python=$(find_python)
[ -n "$python" ] || missing "no Python 3.11, 3.12 or 3.13" "one of them" "install python3 (Debian 12 or 13, Ubuntu 24.04 have it)"

stamp=.venv/adc-bench.stamp
key="$(cat requirements.lock pyproject.toml | sha256sum | cut -c1-64) $("$python" -V) $(pwd)"
install_system_packages
[ "$(cat "$stamp" 2>/dev/null)" = "$key" ] && exit 0

[ -x .venv/bin/python ] && [ "$(.venv/bin/python -V)" = "$("$python" -V)" ] || "$python" -m venv --clear .venv
echo "setup: installing the locked Python packages into .venv (about 6 GB)"
.venv/bin/python -m pip install --quiet --require-hashes --no-deps -r requirements.lock
.venv/bin/python -m pip install --quiet --no-deps --no-build-isolation --no-index -e .
.venv/bin/adc-bench doctor
echo "$key" >"$stamp.tmp"
mv "$stamp.tmp" "$stamp"
