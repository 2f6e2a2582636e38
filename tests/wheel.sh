#!/usr/bin/env bash
# wheel.sh WHEEL SUITE: installs what ./ferrule wheel made in a bare Debian (bookworm or trixie) that has Python and no
# compiler, and runs there the demo, the Python lines of README.md, an environment of Gymnasium, and a man page.
set -euo pipefail
[[ $# -eq 2 && $2 =~ ^(bookworm|trixie)$ ]] || { echo "usage: wheel.sh WHEEL bookworm|trixie" >&2; exit 2; }
. "$(dirname "${BASH_SOURCE[0]}")/fresh_debian.sh"
readme=$(dirname "${BASH_SOURCE[0]}")/../README.md
fresh_debian "$2" python3-venv
"${as_root[@]}" cp "$1" "$fresh/root"
sed -n '/^```python/,/^```/{/^```/!p}' "$readme" | "${as_root[@]}" tee "$fresh/root/lines.py" >/dev/null
"${as_root[@]}" tee "$fresh/root/commands.sh" >/dev/null <<'COMMANDS'
set -e
trap 'printf "wheel: $ %s\n" "$BASH_COMMAND"' DEBUG
cd ~
! command -v c++
python3 -m venv env && . env/bin/activate
pip install -q "$(ls ferrule-*.whl)[gym]"
ferrule --version
ferrule demo
python lines.py
python -c 'import ferrule, gymnasium; print(gymnasium.make("ferrule/Insertion-v0", scene="demo").reset(seed=1))'
! ferrule fit ferrule-demo/episodes --method torch --out network.json
test -s env/share/man/man1/ferrule-record.1.gz
COMMANDS
inside bash /root/commands.sh || { echo "wheel: $1 does not work in a bare $2" >&2; exit 1; }
echo "wheel: $(basename "$1") installs and runs in a bare $2"
