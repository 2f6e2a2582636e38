#!/usr/bin/env python3
"""Makes the tables of docs/results.md: runs the commands that the document shows and lays out what they give.

    bench/results.py                     every table that the program of this version has not made yet: hours
    bench/results.py --only counts       those whose numbers are the same on every machine
    bench/results.py --only tail,plans   these
    bench/results.py --list              which version made each, and how long that took
    bench/results.py --quick --into FILE all that can be made short, with small counts, into a copy

Times need a machine that does nothing else. A table stands between <!-- NAME --> and <!-- /NAME -->, and is replaced as
soon as it is made; Ctrl-C keeps those that are. One that cannot be made stays as it was.
"""

import argparse
import collections
import datetime
import json
import os
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from pathlib import Path
from typing import NamedTuple

from results_layouts import ROOT, NotMade, Result
from results_tables import TABLES, Table

DOCUMENT = ROOT / "docs/results.md"
LEARNERS = ROOT / "build/learners-env/bin/python"
MADE = re.compile(r"^\*Made by ferrule (.+) on ([\d-]+) in (\d+) s on (\d+) processors\.\*$", re.MULTILINE)


class BadInput(Exception):
    """What the user has to change."""


def say(text: str) -> None:
    print(f"results: {text}", file=sys.stderr, flush=True)


class Outcome(NamedTuple):
    result: Result
    seconds: float


class Commands:
    """Runs commands as the document shows them, each once, in a folder of their own."""

    def __init__(self, program: Path, folder: str):
        self.program, self.folder = program, folder
        self.environment = dict(os.environ)
        if LEARNERS.exists():
            self.environment["FERRULE_PYTHON"] = str(LEARNERS)
        (Path(folder) / "examples").symlink_to(ROOT / "examples")
        self.outcomes: dict[str, Outcome | NotMade] = {}

    def run(self, command: str) -> Outcome:
        if command not in self.outcomes:
            say(command)
            try:
                self.outcomes[command] = self.outcome(command)
            except NotMade as why:
                self.outcomes[command] = why
        outcome = self.outcomes[command]
        if isinstance(outcome, NotMade):
            raise outcome
        return outcome

    def outcome(self, command: str) -> Outcome:
        arguments = [a.replace("$python", str(LEARNERS)) for a in shlex.split(command)]
        structured = arguments[:1] == ["./ferrule"] and arguments[1] in ("bench", "compare", "demo", "evaluate",
                                                                                    "record")
        if arguments[0] == "./ferrule":
            arguments[0] = str(self.program)
        begin = time.monotonic()
        run = subprocess.run(arguments + ["--json"] * structured, cwd=self.folder, env=self.environment,
                             stdout=subprocess.PIPE, text=True)
        if run.returncode != 0:
            raise NotMade(f"`{command}` ended with {run.returncode}")
        return Outcome(json.loads(run.stdout) if structured else run.stdout, time.monotonic() - begin)


def version_of(program: Path) -> str:
    try:
        return subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError) as error:
        raise BadInput(f"{program}: cannot be run ({error}); build it, or name another with --program") from None


def between(name: str) -> re.Pattern:
    return re.compile(rf"(<!-- {name} -->\n)(.*?)(<!-- /{name} -->)", re.DOTALL)


def blocks(file: Path) -> dict[str, str]:
    """What stands between the markers of each table. The document must have those of all tables and no others."""
    try:
        text = file.read_text()
    except OSError as error:
        raise BadInput(f"{file}: cannot be read: {error.strerror}") from None
    names = [table.name for table in TABLES]
    for slash, name in re.findall(r"<!-- (/?)(\S+) -->", text):
        if name not in names:
            raise BadInput(f"{file}: <!-- {slash}{name} --> is no table; there are {', '.join(names)}")
    found = {}
    unbroken = re.sub(r" \\\n +", " ", text)
    for table in TABLES:
        inside = between(table.name).findall(text)
        if len(inside) != 1 or "<!--" in inside[0][1]:
            raise BadInput(f"{file}: expected <!-- {table.name} --> and <!-- /{table.name} --> once, "
                           "each on a line of its own")
        found[table.name] = inside[0][1]
        for command in table.commands:
            if not re.search(rf"(^|`){re.escape(command)}($|`)", unbroken, re.MULTILINE):
                raise BadInput(f"{file}: does not show the command that makes <!-- {table.name} -->: {command}")
    return found


def replace(file: Path, name: str, block: str) -> None:
    """Of the document as it is now: its text may have been changed since."""
    blocks(file)
    beside = file.with_name(file.name + ".part")
    beside.write_text(between(name).sub(lambda match: match[1] + block + match[3], file.read_text()))
    os.replace(beside, file)


def made(table: Table, commands: Commands, version: str, quick: bool) -> str:
    shown = table.quick if quick and table.quick else table.commands
    outcomes = {command: commands.run(command) for command in shown}
    took = sum(o.seconds for o in outcomes.values())
    line = f"Made by ferrule {version} on {datetime.date.today()} in {took:.0f} s on {os.cpu_count()} processors."
    if quick:
        line = f"Tried with {'; '.join(f'`{command}`' for command in outcomes)}: no result."
    return f"{table.layout(*(outcomes[command].result for command in shown))}\n\n*{line}*\n"


def make(chosen: list[Table], arguments: argparse.Namespace, version: str) -> int:
    failed = []
    with tempfile.TemporaryDirectory(prefix="ferrule-results-") as folder:
        commands = Commands(arguments.program.resolve(), folder)
        for number, table in enumerate(chosen, 1):
            if any("$python" in command for command in table.commands) and not LEARNERS.exists():
                say(f"{table.name} is left out: `./ferrule test --long` makes build/learners-env, which it needs")
                continue
            try:
                replace(arguments.into, table.name, made(table, commands, version, arguments.quick))
                say(f"{table.name} is made ({number} of {len(chosen)})")
            except NotMade as why:
                failed.append(table.name)
                say(f"{table.name} stays as it was: {why}")
            except (LookupError, TypeError, ValueError):  # the program gives something else than expected
                failed.append(table.name)
                say(f"{table.name} stays as it was: {traceback.format_exc()}")
    if failed:
        say(f"not made: {', '.join(failed)}")
    return 1 if failed else 0


def chosen_tables(arguments: argparse.Namespace, there: dict[str, str], version: str) -> list[Table]:
    known = [table.name for table in TABLES] + ["counts", "timing"]
    for name in arguments.only:
        if name not in known:
            raise BadInput(f"--only: {name} is no table; there are {', '.join(known)}")
    chosen = []
    for table in TABLES:
        if arguments.only and not {table.name, table.kind} & set(arguments.only):
            continue
        by = MADE.search(there[table.name])
        if arguments.quick and table.quick is None and table.name not in arguments.only:
            say(f"{table.name} is left out by --quick: nothing makes it short")
        elif by and by[1] == version and not arguments.again and not arguments.quick:
            say(f"{table.name} is of {version} already; --again makes it again")
        else:
            chosen.append(table)
    return chosen


def print_list(there: dict[str, str]) -> None:
    versions = collections.Counter()
    for table in TABLES:
        by = MADE.search(there[table.name])
        version = f"by ferrule {by[1]}" if by else "not by this script"
        versions[version] += 1
        print(f"{table.name:15} {table.kind:7} {version}" +
              (f" on {by[2]} in {by[3]} s on {by[4]} processors" if by else ""))
    print("made " + "; ".join(f"{version}: {count} of {len(TABLES)}" for version, count in versions.items()))


def main() -> int:
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", type=lambda names: names.split(","), default=[], metavar="NAME,...",
                        help="these tables; counts and timing stand for all of their kind")
    parser.add_argument("--quick", action="store_true",
                        help="small counts, to try the script; not into docs/results.md")
    parser.add_argument("--again", action="store_true", help="those too that this version has made")
    parser.add_argument("--list", action="store_true", help="say what made each table, and make none")
    parser.add_argument("--program", type=Path, default=ROOT / "build/app/ferrule")
    parser.add_argument("--into", type=Path, default=DOCUMENT, metavar="FILE.md",
                        help="docs/results.md, or a copy of it")
    arguments = parser.parse_args()
    try:
        there = blocks(arguments.into)
        if arguments.list:
            print_list(there)
            return 0
        if arguments.quick and arguments.into.samefile(DOCUMENT):
            raise BadInput("--quick makes no results: name a copy of docs/results.md with --into")
        version = version_of(arguments.program)
        return make(chosen_tables(arguments, there, version), arguments, version)
    except BadInput as why:
        say(str(why))
        return 2
    except KeyboardInterrupt:
        say("stopped; tables that were made stay, the others are as they were")
        return 130


if __name__ == "__main__":
    sys.exit(main())
