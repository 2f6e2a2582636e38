#!/usr/bin/env bash
# newcomer.sh [SUITE]: makes a Debian with git and nothing else (debootstrap; SUITE bookworm unless given, or
# trixie), and runs there every command block of README.md of this commit, word for word and in order, from
# `git clone` to the Python lines.
#
# From this machine come only the commit, its certificate authorities, and its settings of a proxy.
set -euo pipefail
suite=${1:-bookworm}
[[ $# -le 1 && $suite =~ ^(bookworm|trixie)$ ]] || { echo "usage: newcomer.sh [bookworm|trixie]" >&2; exit 2; }
cd "$(dirname "${BASH_SOURCE[0]}")/.."
say() { printf 'newcomer: %s\n' "$*"; }

as_root=()
if [[ $EUID -ne 0 ]]; then as_root=(sudo); fi
command -v debootstrap >/dev/null ||
  "${as_root[@]}" apt-get install -y -qq -o DPkg::Lock::Timeout=600 --no-install-recommends debootstrap
fresh=$(mktemp -d)
away() {
  for folder in proc dev; do "${as_root[@]}" umount -l "$fresh/$folder" 2>/dev/null || true; done
  # Never into what is still mounted.
  "${as_root[@]}" rm -rf --one-file-system "$fresh"
}
trap away EXIT
trap 'exit 130' INT TERM

say "a bare Debian, $suite"
"${as_root[@]}" debootstrap --variant=minbase --include=git,ca-certificates "$suite" "$fresh" >"$fresh.log" 2>&1 ||
  { tail -n 20 "$fresh.log" >&2; exit 1; }
rm -f "$fresh.log"
"${as_root[@]}" mount -t proc proc "$fresh/proc"
"${as_root[@]}" mount --bind /dev "$fresh/dev"
"${as_root[@]}" cp -L /etc/resolv.conf "$fresh/etc/resolv.conf"
grep -lsi proxy /etc/apt/apt.conf.d/* | xargs -r "${as_root[@]}" cp -t "$fresh/etc/apt/apt.conf.d" || true
for authorities in /etc/ssl/certs /usr/local/share/ca-certificates; do
  [[ -d $authorities ]] || continue
  "${as_root[@]}" mkdir -p "$fresh$authorities"
  "${as_root[@]}" cp -rL "$authorities/." "$fresh$authorities" 2>/dev/null || true # a link may lead nowhere
done

# The address in README.md leads to this commit.
address=$(sed -n 's/^git clone \([^ ]*\).*/\1/p' README.md | head -n 1)
"${as_root[@]}" git clone -q --bare --no-local --depth 1 "file://$PWD" "$fresh/srv/ferrule.git"
"${as_root[@]}" tee "$fresh/root/.gitconfig" >/dev/null <<GIT
[url "file:///srv/ferrule.git"]
	insteadOf = $address
[safe]
	directory = *
GIT

# README.md's blocks as one script: the shell's as they are, Python's through the environment that README.md makes.
blocks() {
  awk '
    /^```/ {
      if (inside && language == "python") print "PYTHON"
      inside = !inside
      if (inside) language = substr($0, 4)
      if (inside && language == "python") print "env/bin/python - <<\"PYTHON\""
      next
    }
    inside && language == "" { sub(/^\.\/ferrule view/, "until_it_serves &") }
    inside' README.md
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
for made in ferrule-demo/report.html episodes/episode_0020.h5 controller.json trials.html; do test -s "$made"; done
SCRIPT
} | "${as_root[@]}" tee "$fresh/root/commands.sh" >/dev/null

kept=(PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8)
for variable in http_proxy https_proxy no_proxy NODE_EXTRA_CA_CERTS PIP_CERT SSL_CERT_FILE REQUESTS_CA_BUNDLE; do
  [[ -z ${!variable:-} ]] || kept+=("$variable=${!variable}")
done
"${as_root[@]}" chroot "$fresh" /usr/bin/env -i "${kept[@]}" \
  bash -c 'cd ~ && bash commands.sh' </dev/null || { say "README.md does not work in a bare $suite"; exit 1; }
say "README.md works in a bare $suite"
