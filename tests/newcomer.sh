#!/usr/bin/env bash
# newcomer.sh [SUITE]: makes a Debian with git, python3-venv and nothing else (debootstrap; SUITE bookworm unless
# given, or trixie), and runs there every command block of README.md of this commit, word for word and in order, from
# `pip install` of what ./ferrule wheel has made to the main job.
set -euo pipefail
suite=${1:-bookworm}
[[ $# -le 1 && $suite =~ ^(bookworm|trixie)$ ]] || { echo "usage: newcomer.sh [bookworm|trixie]" >&2; exit 2; }
cd "$(dirname "${BASH_SOURCE[0]}")/.."
ls build/wheel/ferrule-*.whl >/dev/null || { echo "newcomer: make the wheel first: ./ferrule wheel" >&2; exit 3; }
. tests/fresh_debian.sh
say() { printf 'newcomer: %s\n' "$*"; }

say "a bare Debian, $suite"
fresh_debian "$suite" git python3-venv

# The addresses in README.md lead to this commit, and to its wheel.
"${as_root[@]}" cp -r build/wheel "$fresh/srv/release"
address=$(sed -n 's/^git clone \([^ ]*\).*/\1/p' README.md | head -n 1)
"${as_root[@]}" git clone -q --bare --no-local --depth 1 "file://$PWD" "$fresh/srv/ferrule.git"
"${as_root[@]}" tee "$fresh/root/.gitconfig" >/dev/null <<GIT
[url "file:///srv/ferrule.git"]
	insteadOf = $address
[safe]
	directory = *
GIT

# README.md's blocks as one script: the shell's as they are, Python's through the environment that README.md makes, and
# none that quotes output.
blocks() {
  awk '
    /^```/ {
      if (inside && language == "python") print "PYTHON"
      inside = !inside
      if (inside) language = substr($0, 4)
      if (inside && language == "python") print "env/bin/python - <<\"PYTHON\""
      next
    }
    inside && language == "" { sub(/^\.\/ferrule view/, "until_it_serves &"); sub(/^release=.*/, "release=file:///srv/release") }
    inside && language != "text"' README.md
}
{
  cat <<'SCRIPT'
# The window serves until Ctrl-C: it must say where, and end.
until_it_serves() {
  "$@" --no-open >view.log 2>&1 &
  local window=$! second
  for ((second = 0; second < 600; second++)); do
    grep -q 'http://127.0.0.1' view.log && break
    kill -0 $window 2>/dev/null || break
    sleep 1
  done
  cat view.log
  grep -q 'http://127.0.0.1' view.log
  kill -INT $window
  wait $window || [[ $? -eq 130 ]]
}
set -e
trap 'echo "newcomer: FAILED: $BASH_COMMAND" >&2' ERR
trap 'printf "\nnewcomer: %(%T)T $ %s\n" -1 "$BASH_COMMAND"' DEBUG
SCRIPT
  blocks
  cat <<'SCRIPT'
trap - DEBUG
for made in ../ferrule-demo/report.html ferrule-demo/report.html episodes/episode_0020.h5 controller.json trials.html; do test -s "$made"; done
SCRIPT
} | "${as_root[@]}" tee "$fresh/root/commands.sh" >/dev/null

inside bash -c 'cd ~ && bash commands.sh' || { say "README.md does not work in a bare $suite"; exit 1; }
say "README.md works in a bare $suite"
