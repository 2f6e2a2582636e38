#!/usr/bin/env bash
# compiles.sh SUITE [CACHE]: every source of this commit, as a bare Debian's compiler and headers take it (SUITE trixie is
# Debian 13). README.md promises that release too; its commands run there in ./ferrule test --long. What the same compiler
# has taken before is in CACHE, a folder of ccache, and is not compiled again.
set -euo pipefail
[[ $# -ge 1 && $# -le 2 && $1 =~ ^(bookworm|trixie)$ ]] || { echo "usage: compiles.sh bookworm|trixie [CACHE]" >&2; exit 2; }
cache=${2:+$(realpath "$2")}
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. tests/fresh_debian.sh
fresh_debian "$1" git
"${as_root[@]}" git clone -q --no-local --depth 1 "file://$PWD" "$fresh/root/ferrule"
[[ -z $cache ]] || share_cache "$cache"
inside /root/ferrule/ferrule test --compile || { echo "compiles: not on a bare $1" >&2; exit 1; }
echo "compiles: on a bare $1"
