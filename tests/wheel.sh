#!/usr/bin/env bash
# wheel.sh WHEEL: installs what ./ferrule wheel made for Debian 12 in a Debian 13 that has Python and no compiler, and
# runs there the demo, the Python lines of README.md, an environment of Gymnasium, and a man page.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/fresh_debian.sh"
readme=$(dirname "${BASH_SOURCE[0]}")/../README.md
fresh_debian trixie python3-venv
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
inside bash /root/commands.sh || { echo "wheel: $1 does not work in a bare Debian 13" >&2; exit 1; }
echo "wheel: $(basename "$1") installs and runs in a bare Debian 13"
