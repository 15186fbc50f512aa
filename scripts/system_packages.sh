#!/bin/sh
# system_packages.sh missing PYTHON      prints the system packages that this machine lacks
# system_packages.sh browser             installs Debian's chromium for the tests of the pages, where that can be done
# system_packages.sh compiler            installs g++ for the tests of the C++ example, where that can be done
# system_packages.sh install PACKAGE...  installs them (as root)
#
# The reference renderer is Mesa's software Vulkan driver, which SAPIEN can use from Mesa 24.3 on.
# Debian 12's own is older; its backports have a newer one. Bubblewrap is the sandbox that submissions run in.
set -eu
mesa_wanted=24.3

is_installed() { [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]; }

is_new_enough() { dpkg --compare-versions "${1:-0}" ge "$mesa_wanted"; }

missing() {
  "$1" -c 'import ensurepip, venv' 2>/dev/null || echo "$(basename "$(readlink -f "$(command -v "$1")")")-venv"
  command -v dpkg-query >/dev/null || return 0  # another system's packages: adc-bench doctor tells what does not work
  is_new_enough "$(dpkg-query -W -f '${Version}' mesa-vulkan-drivers 2>/dev/null)" || echo mesa-vulkan-drivers
  for package in libvulkan1 libx11-6 libstdc++6 bubblewrap; do
    is_installed "$package" || echo "$package"
  done
}

candidate() {  # the version of package $1 that would be installed, from suite $2 if given
  apt-cache ${2:+-o "APT::Default-Release=$2"} policy "$1" 2>/dev/null | awk '$1 == "Candidate:" { print $2 }'
}

# The machine's own sources of suite $1, with suite $2 in its place: one-line lists, then deb822 stanzas.
derive_sources() {
  lists=/etc/apt/sources.list.d
  cat /etc/apt/sources.list $lists/*.list 2>/dev/null |
    sed -n -E "s/^(deb( +\[[^]]*\])? +[^ ]+) +$1 +.*/\1 $2 main/p" | sort -u >$lists/adc-bench.list
  cat_stanzas $lists/*.sources | awk -v from="$1" -v to="$2" '
    BEGIN { RS = ""; FS = "\n" }
    {
      stanza = ""; wanted = 0
      for (i = 1; i <= NF; i++) {
        if ($i ~ /^Types:/) $i = "Types: deb"
        if ($i ~ /^Components:/) $i = "Components: main"
        if ($i ~ /^Enabled: *no/) next
        if ($i ~ /^Suites:/) { wanted = (" " substr($i, 8) " " ~ " " from " "); $i = "Suites: " to }
        stanza = stanza $i "\n"
      }
      if (wanted) print stanza
    }' >$lists/adc-bench.sources
  for list in $lists/adc-bench.list $lists/adc-bench.sources; do
    [ -s "$list" ] || rm "$list"
  done
}

cat_stanzas() {  # a blank line after each file, so that the last stanza of one does not run into the next
  for file in "$@"; do
    if [ -e "$file" ]; then
      cat "$file"
      echo
    fi
  done
}

install() {
  export DEBIAN_FRONTEND=noninteractive
  suite=
  apt-get update -q
  if echo " $* " | grep -q ' mesa-vulkan-drivers ' && ! is_new_enough "$(candidate mesa-vulkan-drivers)"; then
    suite="$(. /etc/os-release && echo "$VERSION_CODENAME")-backports"
    if ! apt-cache policy | grep -q "n=$suite"; then
      derive_sources "${suite%-backports}" "$suite"
      apt-get update -q
    fi
    if ! is_new_enough "$(candidate mesa-vulkan-drivers "$suite")"; then
      echo "error: no Mesa $mesa_wanted or newer for this system; Debian 12 and 13 and Ubuntu 24.04 have one" >&2
      exit 4
    fi
  fi
  apt-get install -q -y --no-install-recommends ${suite:+-t "$suite"} "$@"
}

browser() {  # the tests that want it are skipped without it, so that it is no reason to fail
  command -v chromium >/dev/null && return 0
  if [ "$(id -u)" != 0 ]; then
    echo "no chromium: tests of pages will be skipped (as root: sh scripts/system_packages.sh install chromium)"
  elif [ "$(. /etc/os-release && echo "$ID")" != debian ]; then  # Ubuntu's package of that name is a snap
    echo "no chromium: tests of pages will be skipped"
  else
    install chromium || echo "chromium cannot be installed: tests of pages will be skipped"
  fi
}

compiler() {
  command -v g++ >/dev/null && return 0
  if [ "$(id -u)" != 0 ]; then
    echo "no g++: tests of the C++ example will be skipped (as root: sh scripts/system_packages.sh install g++)"
  else
    install g++ || echo "g++ cannot be installed: tests of the C++ example will be skipped"
  fi
}

command=$1
shift
"$command" "$@"
