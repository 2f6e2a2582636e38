"""The pages of the repository, the commands that they print, and what a command must leave to be as its page says:
the exit code, the files that it names, its own words in what it prints, and the numbers and lines beside it."""

import csv
import glob
import json
import os
import re
import shlex
import time
from typing import NamedTuple

from case import SOURCE

PAGES = sorted(page for pattern in ("*.md", "*/*.md", "*/*/README.md")
               for page in glob.glob(pattern, root_dir=SOURCE) if not re.match(r"build[^/]*/|CHANGELOG\.md$", page))

# Of the numbers beside commands these are printed by none: what holds by proof, examples, medians of rows, how long it
# takes here.
NOT_PRINTED = {
    "README.md": ["a straight push inserts 274 of 1000", "130 stopped by Ctrl-C", "141 the reader"],
    "capture/README.md": ["The median score of the first ten is 73, that of the others 91"],
    "controller/README.md": ["125.2 to 125.3: 22 of 51 inserted", "449 show 99 %, and 4512 show 99.9 %", "0.99 (0.999)",
                             "IEC 61755-1", "of the free 10 mm", "The 10 uN of", "takes 3.5 kB. A command takes 0.4 us, but up to 2 "
                             "ms"],
    "docs/engineer.md": ["grade D of IEC 61755-1"],
    "docs/paper.md": ["-191 uN with the constant", "42.73 GPa", "250 and 8.46e5", "in one of the eight at 10 of 11",
                      "1000 of 1000 in `bench`"],
    "docs/results.md": ["20 simulated demonstrations", "18 um (standard deviation", "10.5 mm", "30 um/s"],
    "docs/scale.md": ["Shard 1 of 2", "shards of 20 minutes"],
    "learn/README.md": ["bias of 0.5 to 20 uN `tuned_by_hand` inserts 72 %",
                        "inserts 85.2, 86.2 and 86.2 % after trials everywhere, and 85.4, 84.0 and 86.4 % after half "
                        "of them above 15 uN (2000 trials", "in 54 s on two cores", "correlation above 0.99",
                        "1.02 times as large of 3000 rows",
                        "windows of 10 s", "Ollivier 2018", "noise of 0.2 standard deviations",
                        "150 epochs", "200 insertions",
                        "With each of six recordings of 20 demonstrations in `bench` it inserts 299 or 300 of 300 "
                        "(`record --scene bench --episodes 20 --skill 0.8 --seed` 1 to 5 and 777, `evaluate --trials "
                        "300 --seed 999`)", "the one of seed 777 inserted 236"],
    "sim/solver/README.md": ["at 1.5 s"],
    "view/README.md": ["on 127.0.0.1"],
}


def read(page):
    with open(os.path.join(SOURCE, page)) as file:
        return file.read()


class Command(NamedTuple):
    language: str  # "sh" or "python"
    text: str  # as it is printed
    block: int  # which block of the page it stands in; -1: in a sentence or a table


class Page:
    """`commands` in order; `quoted`, by block, the lines of a block of language "text" after it; and `beside`, by
    block, the prose and tables after it, up to the next block of commands or heading, without the phrases `excused`."""

    def __init__(self, text, excused=()):
        self.commands, self.quoted, self.beside = [], {}, {}
        parts = re.split(r"^```(\w*)\n(.*?)^```$", text, flags=re.S | re.M)
        last = None
        for block, (prose, language, code) in enumerate(zip(parts[0::3], parts[1::3] + [""], parts[2::3] + [""])):
            beside, *rest = re.split(r"^#+ ", prose, maxsplit=1, flags=re.M)
            if last is not None:
                self.beside[last] = self.beside.get(last, "") + beside
            if rest:
                last = None
            self.commands += [Command("sh", " ".join(command.split()), -1)
                              for command in re.findall(r"`(\./ferrule [^`]*)`", prose)]
            if language == "text" and last is not None:
                self.quoted[last] = code.splitlines()
            elif language == "python":
                self.commands.append(Command("python", code, block))
            elif language in ("", "sh", "bash"):
                lines = [re.sub("^env/bin/ferrule ", "./ferrule ", line)  # where the wheel is installed
                         for line in code.replace("\\\n", " ").splitlines()]
                lines = [line for line in lines if line.startswith("./ferrule ")]
                self.commands += [Command("sh", line, block) for line in lines]
                last = block if lines else None
        for phrase in excused:
            words = r"\s+".join(map(re.escape, phrase.split()))
            without = {block: re.sub(words, " ", beside) for block, beside in self.beside.items()}
            if without == self.beside:
                raise ValueError(f"the page does not say beside a command: {phrase}")
            self.beside = without


class Ran(NamedTuple):
    code: int
    out: str
    err: str


def words_of(command):
    """Of the program, and the file that its output goes to."""
    words = shlex.split(command, comments=True)
    if ">" in words:
        return words[:words.index(">")], words[words.index(">") + 1]
    return words, None


WRITES = {"--out", "--plot", "--report", "--trials-out", "--header", "--torchscript", "--export", "--robomimic",
          "--lerobot", "--mcap"}
# What a file of this kind has in its first kilobyte.
KINDS = {".svg": b"<svg", ".html": b"<!doctype html", ".h5": b"\x89HDF", ".h": b"#", ".csv": b",", ".json": b"{",
         ".pt": b"PK"}


def files_of(command):
    words, redirected = words_of(command)
    writes = WRITES | ({"--csv"} if "export-episodes" in words else set())
    named = [value for option, value in zip(words, words[1:]) if option in writes]
    if words[1:] == ["demo"]:
        named.append("ferrule-demo/report.html")
    return named + ([redirected] if redirected else [])


def wrong_file(path, begun):
    """Empty: it is there, newer than `begun`, and of the kind that its name says."""
    if os.path.isdir(path):
        inside = [f for f in glob.glob(path + "/**", recursive=True, include_hidden=True) if os.path.isfile(f)]
        newer = [f for f in inside if os.path.getmtime(f) >= begun and os.path.getsize(f)]
        return "" if newer else f"nothing new is in {path}/"
    if not os.path.isfile(path):
        return f"there is no {path}"
    if os.path.getmtime(path) < begun:
        return f"{path} was not written"
    with open(path, "rb") as file:
        if KINDS.get(os.path.splitext(path)[1], b"") not in (beginning := file.read(1000)).lower() + beginning:
            return f"{path} is no {os.path.splitext(path)[1]}"
    return "" if os.path.getsize(path) else f"{path} is empty"


def is_csv(printed):
    return re.match(r"[^\n]*,command\n", printed)


def made_by(printed):
    """The commands that a result says it was made by: as text, JSON, or CSV."""
    found = re.findall(r"^made by ferrule [^\n]*?\): (.*?)(?:; read .*)?$", printed, re.M)
    if printed.startswith("{"):
        found.append(json.loads(printed)["provenance"]["command"])
    elif is_csv(printed):
        found.append(list(csv.reader(printed.splitlines()[:2]))[1][-1])
    return [shlex.split(command) for command in found]


def complaints(command, ran, folder, begun):
    """Where a run was not what `command` and its comment say, in words. `begun`: when, as os.path.getmtime."""
    found = []
    code = re.search(r"#.*exit code (\d+)", command)
    if ran.code != int(code[1] if code else 0):
        return [f"exit code {ran.code}: {ran.err[-2000:]}"]
    words, redirected = words_of(command)
    found += [wrong for file in files_of(command) if (wrong := wrong_file(os.path.join(folder, file), begun))]
    if words[1] == "record" and "--episodes" in words and not found:
        out, count = (words[words.index(option) + 1] for option in ("--out", "--episodes"))
        new = [f for f in glob.glob(os.path.join(folder, out, "*.h5")) if os.path.getmtime(f) >= begun]
        if len(new) != int(count):
            found.append(f"{len(new)} new episodes are in {out}/")
    printed = ran.out
    if redirected and not found:
        with open(os.path.join(folder, redirected)) as file:
            printed = file.read()
    if "--shard" in words or words[1] == "submit":  # the result is that of `merge`
        if not re.search("ferrule merge|sh .*/submit.sh", printed):
            found.append("does not say what comes next")
    elif words[1] in ("report", "export-episodes"):
        found += [f"does not say that it wrote {file}" for file in files_of(command)
                  if f"wrote {file}" not in (ran.out + ran.err).splitlines()]
    elif ["ferrule", *words[1:]] not in made_by(printed) and not (words[1] == "merge" and made_by(printed)):
        found.append(f"says to be made by {made_by(printed)}")
    return found


def python_complaints(block, ran):
    """A line `print(...)  # word` prints that word."""
    if ran.code != 0:
        return [f"exit code {ran.code}: {ran.err[-2000:]}"]
    return [f"does not print {word}" for word in re.findall(r"(?m)^print\(.*\)  # (\w+)$", block)
            if word not in ran.out.split()]


NUMBER = r"(?<![\w.,/-])[-+]?\d+(?:,\d{3})*(?:\.\d+)?(?:e[-+]?\d+)?(?![\w/])"
COUNTS = r"\b\d+\s+of\s+\d+\b"
ROW_AT_A_TIME = r"^\| (\d+(?:\.\d+)?) s \|(.*)$"


def value(number):
    return float(number.replace(",", ""))


def rounds_to(exact, number):
    """Whether a page may print `number` for it: rounded, without its sign, in a unit of another power of a thousand,
    or in percent."""
    digits = re.fullmatch(r"[-+]?\d+(?:\.(\d+))?(?:e([-+]?\d+))?", number.replace(",", ""))
    last = 10.0 ** (int(digits[2] or 0) - len(digits[1] or ""))
    return any(abs(abs(exact) * unit - abs(value(number))) <= 0.5001 * last for unit in (1, 1e3, 1e-3, 1e6, 1e-6, 100))


class Printed:
    """What commands printed. Of a table as CSV the numbers are the least and the largest of each column, and what has
    a time `t_s` can be asked for it."""

    def __init__(self):
        self.text, self.lines, self.numbers, self.tables = "", set(), [], []

    def add(self, ran):
        self.text += ran.out + ran.err
        self.lines |= set((ran.out + ran.err).splitlines())
        text = ran.err if is_csv(ran.out) else ran.out + ran.err
        if ran.out.startswith("{"):
            text = text.replace(",", ", ")  # of a list; in a text it is between thousands
        self.numbers += [value(number) for number in re.findall(NUMBER, re.sub(r"made by ferrule.*", "", text))]
        if is_csv(ran.out):
            rows = list(csv.DictReader(ran.out.splitlines()))
            columns = {key: [float(row[key]) for row in rows] for key in rows[0] if re.fullmatch(NUMBER, rows[0][key])}
            self.numbers += [each for column in columns.values() for each in (min(column), max(column))]
            self.tables.append(columns)

    def at(self, time):
        """The numbers of the rows at this time; none where no table has one."""
        return [column[row] for columns in self.tables if "t_s" in columns for column in columns.values()
                for row in [min(range(len(column)), key=lambda k: abs(columns["t_s"][k] - time))]
                if abs(columns["t_s"][row] - time) < 0.05]


def not_printed(prose, printed):
    """What `prose` claims and `printed` does not have: "22 of 51" to the letter, numbers of a row "| 8.5 s | ..." at
    that time, and others rounded. Code, links, comments, and numbers of equations claim nothing."""
    prose = re.sub(r"<!-- (\w+) -->.*?<!-- /\1 -->", " ", prose, flags=re.S)  # made by bench/results.py
    prose = re.sub(r"<!--.*?-->|`[^`]*`|\]\([^)]*\)|^\*Made by.*$|\(\d+\w?\)", " ", prose, flags=re.S | re.M)
    missing = []
    for time_s, row in re.findall(ROW_AT_A_TIME, prose, re.M):
        if there := printed.at(float(time_s)):
            missing += [n for n in re.findall(NUMBER, row) if not any(rounds_to(each, n) for each in there)]
            prose = prose.replace(row, "")
    missing += [count for count in re.findall(COUNTS, prose) if " ".join(count.split()) not in printed.text]
    return missing + [number for number in re.findall(NUMBER, re.sub(COUNTS, " ", prose))
                      if not any(rounds_to(each, number) for each in printed.numbers)]


def findings(page, run, folder, cut=lambda command: command, left_out=lambda command: False):
    """Runs the commands of a page by `run(language, command)` in `folder`, each `cut` to what is enough, unless it is
    `left_out`: pairs of a command, or of what stands beside one, and what is wrong with it. Beside a command that is
    cut, or that reads what such a one has written, nothing is compared."""
    found, printed, before = [], {}, Printed()
    shortened, made_short = set(), set()  # blocks; files and folders
    for language, text, block in page.commands:
        if left_out(text):
            continue
        command = cut(text) if language == "sh" else text
        begun = time.time() - 0.01  # a file's time is that of the last tick of a clock
        ran = run(language, command)
        wrong = complaints(command, ran, folder, begun) if language == "sh" else python_complaints(command, ran)
        found += [(command, each) for each in wrong]
        named = set() if language == "python" else {word.split("/")[0] for word in words_of(command)[0]}
        wrote = set() if language == "python" else {file.split("/")[0] for file in files_of(command)}
        if command != text or named & made_short - wrote:
            shortened.add(block)
            made_short |= wrote
            continue
        made_short -= wrote
        for pool in (printed.setdefault(block, Printed()), before):
            pool.add(ran)
            if language == "sh" and not wrong and (file := words_of(command)[1]):
                with open(os.path.join(folder, file)) as redirected:
                    pool.add(Ran(0, redirected.read(), ""))
    for block in page.beside.keys() & printed.keys() - shortened:
        found += [(line, "is not printed") for line in page.quoted.get(block, []) if line not in printed[block].lines]
        missing = not_printed(" | ".join(not_printed(page.beside[block], printed[block])), before)
        found += [(number, f"is not printed, but stands in: {page.beside[block].strip()}") for number in missing]
    return found
