#!/usr/bin/env python3
"""How long compiling takes, from what ninja wrote down of a build: makes the table of docs/building.md.

    CCACHE_RECACHE=1 ./ferrule test    # or another build of all, in an empty build/, on a machine that does nothing else
    bench/build_times.py

An edit compiles again each object that reads the file (`ninja -t deps`). Its time is that of these objects in
`.ninja_log`, shared by the processors of this machine, and no shorter than the longest of them.
"""

import argparse
import datetime
import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BLOCK = re.compile(r"(<!-- build_times -->\n)(.*?)(<!-- /build_times -->)", re.DOTALL)


def ninja(build: Path, *words: str) -> str:
    return subprocess.run(["ninja", "-C", build, *words], capture_output=True, text=True, check=True).stdout


def times(build: Path) -> dict[str, float]:
    """Of each object and precompiled header, when it was last compiled [s]."""
    entries = (line.split("\t") for line in (build / ".ninja_log").read_text().splitlines()[1:])
    return {output: (int(end) - int(start)) / 1000 for start, end, _, output, _ in entries
            if output.endswith((".o", ".gch", ".pch"))}


def readers(build: Path) -> dict[str, set[str]]:
    """Of each source and header, relative to the repository, the objects that read it."""
    found: dict[str, set[str]] = {}
    for block in ninja(build, "-t", "deps").split("\n\n"):
        name, *files = block.strip().splitlines() or [""]
        for file in files:
            path = os.path.relpath(os.path.normpath(build / file.strip()), ROOT)
            found.setdefault(path, set()).add(name.partition(":")[0])
    return found


def row(what: str, objects: set[str], took: dict[str, float]) -> str:
    each = [took[name] for name in objects if name in took]
    wall = max(sum(each) / os.cpu_count(), max(each, default=0))
    return f"| {what} | {len(each)} | {sum(each):.0f} | {wall:.0f} |"


def worst(pattern: str, of: dict[str, set[str]], took: dict[str, float]) -> str:
    return max((path for path in of if re.fullmatch(pattern, path)),
               key=lambda path: sum(took.get(name, 0) for name in of[path]))


def table(build: Path) -> str:
    took, of = times(build), readers(build)
    program = set(ninja(build, "-t", "inputs", "app/ferrule").split())
    lines = ["| what is compiled | objects | sum of their times [s] | together [s] |", "|---|---|---|---|",
             row("the program, in an empty folder", program & took.keys(), took),
             row("with tests, examples and what loads libtorch and CVODE", set(took), took)]
    for what, pattern in (("a line in a law's header", r"sim/laws/\w+\.hpp"),
                          ("a line in a source of a library", r"(sim|haptic|insertion|capture|controller|learn)/.*\.cpp"),
                          ("a line in a source of the program", r"app/.*\.cpp"),
                          ("a line in a test", r"tests/.*_test\.cpp")):
        path = worst(pattern, of, took)
        lines.append(row(f"{what}, at worst (`{path}`)", of[path], took))
    return "\n".join(lines)


def commit() -> str:
    return subprocess.run(["git", "-C", ROOT, "rev-parse", "--short=10", "HEAD"], capture_output=True, text=True,
                          check=True).stdout.strip()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=Path, default=ROOT / "build", help="the folder that was built in")
    parser.add_argument("--into", type=Path, default=ROOT / "docs/building.md", metavar="FILE.md")
    arguments = parser.parse_args()
    text = arguments.into.read_text()
    if len(BLOCK.findall(text)) != 1:
        print(f"build_times: {arguments.into}: expected <!-- build_times --> and <!-- /build_times --> once",
              file=sys.stderr)
        return 2
    try:
        made = table(arguments.build.resolve())
    except (OSError, subprocess.CalledProcessError, ValueError) as why:
        print(f"build_times: {arguments.build}: expected a folder where ninja has built all, with its .ninja_log "
              f"({why})", file=sys.stderr)
        return 2
    made += (f"\n\n*Made by bench/build_times.py at commit {commit()} on {datetime.date.today()}, on "
             f"{os.cpu_count()} processors.*\n")
    beside = arguments.into.with_name(arguments.into.name + ".part")
    beside.write_text(BLOCK.sub(lambda match: match[1] + made + match[3], text))
    os.replace(beside, arguments.into)
    return 0


if __name__ == "__main__":
    sys.exit(main())
