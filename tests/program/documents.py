"""Every documented command: each `./ferrule ...` and each Python block of a page, in order, in a folder that was empty
before its first one. Each must leave what its page says (documented.py).

Python blocks need the package: run this with a Python that has it.
"""

import os
import re
import subprocess
import sys
import unittest

from case import PROGRAM, Case, main
from documented import NOT_PRINTED, PAGES, Page, Ran, findings, read

LONG = bool(os.environ.get("FERRULE_LONG"))

# How many trials and the like are enough here, of what would take more than some seconds. What is printed stays what a
# reader runs, and FERRULE_LONG=1 runs it. The numbers beside a command that is cut are not compared.
SLOW = "search|tuned|improved|remembers|--baseline searching"
DEAR = rf"^(./ferrule (?:evaluate (?:{SLOW})|compare|sensitivity|map|sweep)\S*"
CUTS = [(DEAR + r"(?= |$)(?!.*--trials).*?)( > \S+)?$", r"\1 --trials 4\2"), (DEAR + r".*--trials) \d+", r"\1 4"),
        (r"^(./ferrule evaluate (?!controller.json|.*chosen).*--trials) [1-9]\d{3,}\b", r"\1 4"),
        (r"^(./ferrule improve .*)--trials \d+", r"\1--trials 1000 --unseen 20"),
        (r"^(./ferrule improve .*)--also \S+", r"\1"), (r"^(./ferrule improve .*)ladder/f", r"\1ladder/d"),
        (r"(--ladder .*--trials) 4", r"\1 1"), (r"^(./ferrule compare (?!.*--learners).*)", r"\1 --learners linear"),
        (r"--seeds 1\.\.5", "--seeds 1..2"), (r"(--demonstrations) \S+", r"\1 5"),
        (r"(--scene hard --episodes) 100\b", r"\1 2"),
        (r"--episodes 100\b", "--episodes 6"), (r"insertion,(torch,)?dagger|(?<=--learners )torch", "linear")]

# What is not run, and why.
LEFT_OUT = [
    (r"^./ferrule .*(VERB|WORD|NAME|\.\.\.)", "stands for a command"),
    (r"^./ferrule (test|wheel|playground|package)\b", "tests/newcomer.sh and this suite are that"),
    (r"^./ferrule import\b", "needs a try saved in a browser: view.py, tests/page/playground.mjs"),
    (r"^./ferrule view\b(?!.*--export)", "serves until Ctrl-C: view.py, tests/newcomer.sh"),
    (r"^./ferrule (view|score) .*\b(ada|ben)\b", "needs what persons recorded in the window"),
    (r"^./ferrule devices --test$|^./ferrule (record|view) .*--device (?!fake:)", "needs a device, and a hand at it"),
    (r"\$python|python examples/learners|^import (subprocess|submitit)|^(import|from) lerobot",
     "needs learners of PyPI: ./ferrule test --long"),
    (r"\b(data/controllers|examples/policy)", "is for the folder of a clone, as its document says"),
    (r"^./ferrule bench\b", "minutes: bench.py runs its parts"),
    (r"\bremembers\.json", "minutes: policies.py fits one to fewer episodes"),
    (r"^./ferrule (-|$)", "installs and builds nothing: start.py"),
]


def cut(text):
    command, comment = re.fullmatch(r"(.*?)(\s+#.*)?", text).groups("")
    for pattern, enough in CUTS:
        command = re.sub(pattern, enough, command)
    return command + comment


def left_out(command):
    return any(re.search(pattern, command, re.M) for pattern, why in LEFT_OUT)


class Commands(Case):
    def run_in_folder(self, language, command):
        words = ["bash", "-c", command] if language == "sh" else [sys.executable, "-c", command]
        run = subprocess.run(words, cwd=self.folder, env={**os.environ, "FERRULE_PYTHON": sys.executable},
                             timeout=7200 if LONG else 600, capture_output=True, text=True, stdin=subprocess.DEVNULL)
        return Ran(run.returncode, run.stdout, run.stderr)

    def check(self, name):
        os.symlink(PROGRAM, self.path("ferrule"))
        # The tables of results.md are those of bench/results.py, which takes hours.
        enough = (lambda command: command) if LONG and "results.md" not in name else cut
        page = Page(read(name), NOT_PRINTED.get(name, []))
        for what, wrong in findings(page, self.run_in_folder, self.folder, enough, left_out):
            with self.subTest(what=what):
                self.fail(wrong)


class Results(Commands):
    pass


class Documents(Commands):
    def test_every_rule_is_needed(self):
        commands = [command.text for page in PAGES for command in Page(read(page)).commands]
        self.assertGreater(len(commands), 300)
        for pattern, why in LEFT_OUT:
            self.assertTrue(any(re.search(pattern, command, re.M) for command in commands), (pattern, why))


for name in PAGES:
    short = re.sub(r"\W+", "_", name)
    setattr(Results if short == "docs_results_md" else Documents, "test_" + short,
            lambda self, name=name: self.check(name))

if __name__ == "__main__":
    if sys.argv[4:] == ["--list"]:  # so that several run at once
        print(*(f"Documents.{name}" for name in unittest.TestLoader().getTestCaseNames(Documents)), sep="\n")
    else:
        main()
