#!/bin/sh
# Writes requirements.lock from pyproject.toml (needs uv): what fits together on every Python that setup.sh accepts,
# with hashes and no address of any package index. Versions already locked stay, unless --upgrade is given.
set -eu
cd "$(dirname "$0")/.."
exec uv pip compile pyproject.toml --extra dev --output-file requirements.lock "$@" \
  --universal --python-version 3.11 --generate-hashes --no-emit-package opencv-python \
  --no-emit-index-url --no-emit-find-links --custom-compile-command scripts/lock.sh --quiet
