#!/usr/bin/env bash
# compiles.sh SUITE: every source of this commit, as a bare Debian's compiler and headers read it (SUITE trixie is
# Debian 13). README.md promises that release too; its commands run there in ./ferrule test --long.
set -euo pipefail
[[ $# -eq 1 && $1 =~ ^(bookworm|trixie)$ ]] || { echo "usage: compiles.sh bookworm|trixie" >&2; exit 2; }
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. tests/fresh_debian.sh
fresh_debian "$1" git
"${as_root[@]}" git clone -q --no-local --depth 1 "file://$PWD" "$fresh/root/ferrule"
inside /root/ferrule/ferrule test --syntax || { echo "compiles: not on a bare $1" >&2; exit 1; }
echo "compiles: on a bare $1"
