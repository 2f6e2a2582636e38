#!/usr/bin/env bash
# package.sh BUILD: makes the Debian packages of a build, installs the program's in a Debian made for
# this by debootstrap, and inserts a fibre there.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/fresh_debian.sh"
build=$1
cd "$build"
rm -f ./*.deb
cpack -G DEB >cpack.log || { cat cpack.log >&2; exit 1; }
fresh_debian bookworm
"${as_root[@]}" cp ferrule_*.deb libferrule-dev_*.deb "$fresh/tmp"
inside bash -c 'export DEBIAN_FRONTEND=noninteractive; apt-get update -qq && apt-get install -y -qq --no-install-recommends /tmp/ferrule_*.deb' >install.log 2>&1 ||
  { cat install.log >&2; exit 1; }

fail() { echo "package: $1" >&2; exit 1; }
inside ferrule record --scene demo --operator simulated --episodes 3 --out /tmp/episodes >record.log 2>&1 ||
  { cat record.log >&2; fail "it cannot record"; }
[[ $(inside ferrule replay /tmp/episodes/episode_0001.h5 --verify) == *identical* ]] || fail "it cannot replay"
inside ferrule fit /tmp/episodes --out /tmp/controller.json >fit.log 2>&1 || { cat fit.log >&2; fail "it cannot fit"; }
[[ $(inside ferrule evaluate /tmp/controller.json --scene demo --trials 20 --json) == *inserted* ]] || fail "it cannot evaluate"
inside test -s /usr/share/ferrule/scenes/demo.json || fail "no scenes"
contents=$(dpkg-deb -c ferrule_*.deb)
for verb in record fit evaluate; do
  [[ $contents == *"man1/ferrule-$verb.1.gz"* ]] || fail "no man page of $verb"
done
words=$(inside bash -c '. /usr/share/bash-completion/completions/ferrule
  COMP_WORDS=(ferrule evaluate --scene ti) COMP_CWORD=3; _ferrule; echo "${COMPREPLY[@]}"
  COMP_WORDS=(ferrule eval) COMP_CWORD=1; _ferrule; echo "${COMPREPLY[@]}"
  COMP_WORDS=(ferrule fit --me) COMP_CWORD=2; _ferrule; echo "${COMPREPLY[@]}"')
[[ $words == $'tight\nevaluate\n--method' ]] || fail "completion says: $words"
echo "package: $(ls ferrule_*.deb) installs and runs"
