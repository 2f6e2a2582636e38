"""Every documented command as it is printed: each `./ferrule ...` and each Python block of a document, in
order, in a folder that was empty before its first one.

Python blocks need the package: run this with a Python that has it.
"""

import glob
import os
import re
import subprocess
import sys
import unittest

from case import PROGRAM, SOURCE, Case, main

# How many trials and the like are enough here. What is printed stays what a reader runs.
CUTS = [(r"\s+#.*", ""), (r"(?m)^((?!./ferrule improve).*)--trials \d+", r"\1--trials 4"),
        (r"^(./ferrule improve .*)--trials \d+", r"\1--trials 1000 --unseen 20"),
        (r"^(./ferrule improve .*)--also \S+", r"\1"),
        (r"^(./ferrule improve .*)ladder/f", r"\1ladder/d"), (r"--scenes \d+", "--scenes 1"),
        (r"^(./ferrule (?:compare|evaluate|sweep|map|sensitivity)\b(?!.*--trials).*)", r"\1 --trials 4"),
        (r"(--ladder .*--trials) 4", r"\1 1"),
        (r"^(./ferrule compare (?!.*--learners).*)", r"\1 --learners insertion"),
        (r"--seeds 1\.\.5", "--seeds 1..2"), (r"--demonstrations \S+", "--demonstrations 5"),
        (r"--episodes (20|100)\b", "--episodes 6"), (r"insertion,(torch,)?dagger", "insertion")]

# What is not run, and why.
LEFT_OUT = [
    (r"^./ferrule .*(VERB|WORD|NAME|\.\.\.|\[)", "stands for a command"),
    (r"^./ferrule (test|wheel)\b", "tests/newcomer.sh and this suite are that"),
    (r"^./ferrule view\b(?!.*--export)", "serves until Ctrl-C: view.py, tests/newcomer.sh"),
    (r"^./ferrule (view|score) .*\b(ada|ben)\b", "needs what persons recorded in the window"),
    (r"^./ferrule devices --test$|^./ferrule (record|view) .*--device (?!fake:)", "needs a device, and a hand at it"),
    (r"\$python|python examples/learners|^import (subprocess|submitit)|^(import|from) lerobot", "needs learners of PyPI: ./ferrule test --long"),
    (r"\b(data/controllers|examples/policy)", "is for the folder of a clone, as its document says"),
    (r"^./ferrule bench\b", "minutes: bench.py runs its parts"),
]

# What ends with another exit code than 0, as its document says.
FAILS = {r"^./ferrule doctor --device pen --scene adhesive": 1}


def blocks(text):
    """The commands of a document in order: ("sh" or "python", text)."""
    parts = re.split(r"^```(\w*)\n(.*?)^```$", text, flags=re.S | re.M)
    for prose, language, block in zip(parts[0::3], parts[1::3] + [""], parts[2::3] + [""]):
        for command in re.findall(r"`(\./ferrule [^`]*)`", prose):
            yield "sh", " ".join(command.split())
        if language == "python":
            yield "python", block
        elif language in ("", "sh", "bash"):
            for line in block.replace("\\\n", " ").splitlines():
                if line.startswith("./ferrule "):
                    yield "sh", line


def left_out(command):
    return any(re.search(pattern, command, re.M) for pattern, why in LEFT_OUT)


class Commands(Case):
    def check(self, document):
        os.symlink(PROGRAM, self.path("ferrule"))
        environment = {**os.environ, "FERRULE_PYTHON": sys.executable}
        with open(document) as file:
            commands = list(blocks(file.read()))
        for language, command in commands:
            if language == "sh":
                for pattern, enough in CUTS:
                    command = re.sub(pattern, enough, command)
            if left_out(command):
                continue
            words = [sys.executable, "-c", command]
            if language == "sh":
                words = ["bash", "-c", command]
            with self.subTest(command=command):
                run = subprocess.run(words, cwd=self.folder, env=environment, timeout=600,
                                     capture_output=True, text=True, stdin=subprocess.DEVNULL)
                expected = next((FAILS[f] for f in FAILS if re.search(f, command)), 0)
                self.assertEqual(run.returncode, expected, run.stderr[-2000:])


class Results(Commands):
    pass


class Documents(Commands):
    # Uncut: the numbers of the recipe are those that its commands print.
    @unittest.skipUnless(os.environ.get("FERRULE_LONG"), "takes minutes: ./ferrule test --long")
    def test_numbers_of_the_engineer(self):
        os.symlink(PROGRAM, self.path("ferrule"))
        text = open(os.path.join(SOURCE, "docs/engineer.md")).read()
        printed = ""
        for _, command in blocks(text):
            printed += subprocess.run(["bash", "-c", command], cwd=self.folder, check=True, stdout=subprocess.PIPE,
                                      stderr=subprocess.STDOUT, text=True).stdout
        prose = re.sub(r"^```\n.*?^```$", "", text, flags=re.S | re.M)
        for number in re.findall(r"\d+\.\d+", prose):
            self.assertIn(number, printed)

    # Uncut, too: the first page claims what its main job and its demo print.
    @unittest.skipUnless(os.environ.get("FERRULE_LONG"), "takes a minute: ./ferrule test --long")
    def test_numbers_of_the_result(self):
        os.symlink(PROGRAM, self.path("ferrule"))
        text = open(os.path.join(SOURCE, "README.md")).read()
        job = [command for _, command in blocks(text[text.index("## The main job"):])]
        evaluation = next(k for k, command in enumerate(job) if command.startswith("./ferrule evaluate"))
        printed = ""
        for command in ["./ferrule demo"] + job[:evaluation + 1]:
            printed += subprocess.run(["bash", "-c", command], cwd=self.folder, check=True, stdout=subprocess.PIPE,
                                      stderr=subprocess.STDOUT, text=True).stdout
        claimed = re.search(r"\*\*The result\.\*\*(.*?)Into a bore", text, re.S).group(1)
        counts = re.findall(r"\d+ of \d+", " ".join(claimed.split()))
        self.assertGreater(len(counts), 3)
        for count in counts:
            self.assertIn(f": {count} inserted", printed)

    def test_every_rule_leaves_something_out(self):
        commands = [command for document in DOCUMENTS
                    for language, command in blocks(open(document).read())]
        self.assertGreater(len(commands), 100)
        for pattern, why in LEFT_OUT:
            self.assertTrue(any(re.search(pattern, command) for command in commands), (pattern, why))


DOCUMENTS = sorted(f for pattern in ("*.md", "*/*.md", "*/*/README.md")
                   for f in glob.glob(os.path.join(SOURCE, pattern))
                   if not re.search(r"/(build[^/]*|CHANGELOG\.md)(/|$)", f[len(SOURCE):]))
for name in DOCUMENTS:
    short = re.sub(r"\W+", "_", os.path.relpath(name, SOURCE))
    setattr(Results if short == "docs_results_md" else Documents, "test_" + short,
            lambda self, name=name: self.check(name))

if __name__ == "__main__":
    main()
