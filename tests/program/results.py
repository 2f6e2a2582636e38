import glob
import os
import re
import signal
import subprocess
import sys

from case import PROGRAM, SOURCE, Case, ferrule, main

SCRIPT = os.path.join(SOURCE, "bench/results.py")
DOCUMENT = os.path.join(SOURCE, "docs/results.md")
SCENES = len(glob.glob(os.path.join(SOURCE, "data/scenes/*.json"))) - 1  # without the schema

# Takes the place of the program: one benchmark gives a row, one takes long, the others fail.
STAND_IN = """#!/bin/sh
case "$*" in
  --version) cat {folder}/version ;;
  "bench recording --json")
    echo x >> {folder}/runs
    echo '{{"rows": [{{"scene": "bench", "rows": 1234, "us_per_row": 3, "us_per_row_written": 17, "kB_per_s": 500}}]}}' ;;
  "bench sensors --trials 60 --json") exec sleep 60 ;;
  *) echo "no such thing" >&2; exit 3 ;;
esac
"""


def read(file):
    with open(file) as text:
        return text.read()


def block(text, name):
    return re.search(f"<!-- {name} -->\n(.*?)<!-- /{name} -->", text, re.DOTALL)[1]


def rows(text, name):
    """Those of its table, below header and rule."""
    return [line for line in block(text, name).split("\n") if line.startswith("|")][2:]


class Results(Case):
    def setUp(self):
        super().setUp()
        self.copy = self.path("results.md")
        with open(self.copy, "w") as file:
            file.write(read(DOCUMENT))

    def results(self, *arguments):
        return subprocess.run([sys.executable, "-B", SCRIPT, *arguments], capture_output=True, text=True, timeout=600)

    def stand_in(self, version):
        with open(self.path("version"), "w") as file:
            file.write(version + "\n")
        with open(self.path("program"), "w") as file:
            file.write(STAND_IN.format(folder=self.folder))
        os.chmod(self.path("program"), 0o755)
        return ["--program", self.path("program"), "--into", self.copy]

    def assert_only_recording_is_made(self):
        before, after = read(DOCUMENT), read(self.copy)
        self.assertEqual(after, before.replace(block(before, "recording"), block(after, "recording")))
        self.assertIn("| 1,234 |", block(after, "recording"))

    def test_the_document_has_the_markers_and_commands_of_every_table_and_no_others(self):
        run = self.results("--list")
        self.assertEqual(run.returncode, 0, run.stderr)
        names = [line.split()[0] for line in run.stdout.splitlines()[:-1]]
        # All by this minor version: patches change the last bits of steps, and no result.
        minor = ferrule("--version").stdout.split()[0].rsplit(".", 1)[0]
        for line in run.stdout.splitlines()[:-1]:
            self.assertIn(f" by ferrule {minor}.", line)
        self.assertEqual(sorted(names), sorted(re.findall("<!-- ([a-z]+) -->", read(DOCUMENT))))
        for old, new, says in (("<!-- /turns -->", "", "<!-- /turns -->"),
                               ("<!-- turns -->", "<!-- tuns -->", "<!-- tuns --> is no table"),
                               ("bench turns --scenes 6", "bench turns", "./ferrule bench turns --scenes 6")):
            with open(self.copy, "w") as file:
                file.write(read(DOCUMENT).replace(old, new))
            run = self.results("--list", "--into", self.copy)
            self.assertEqual((run.returncode, run.stdout), (2, ""))
            self.assertIn(says, run.stderr)

    def test_quick_tables_have_the_columns_of_the_document_and_their_rows(self):
        counts = {"recording": 2, "tail": SCENES + 1, "events": 1, "turns": 6, "parts": SCENES, "plans": 1}
        run = self.results("--quick", "--only", ",".join(counts), "--program", PROGRAM, "--into", self.copy)
        self.assertEqual(run.returncode, 0, run.stderr)
        before, after = read(DOCUMENT), read(self.copy)
        for name, count in counts.items():
            self.assertEqual(len(rows(after, name)), count, block(after, name))
            self.assertIn("no result", block(after, name))
            header = block(before, name).split("\n")[0].replace("of 100,", "of 1,")
            self.assertEqual(block(after, name).split("\n")[0], header)
            for row in rows(after, name):
                self.assertEqual(row.count("|"), header.count("|"))
            before = before.replace(block(before, name), block(after, name))
        self.assertEqual(after, before)  # nothing else is touched

    def test_quick_does_not_touch_the_document(self):
        run = self.results("--quick", "--program", PROGRAM)
        self.assertEqual(run.returncode, 2)
        self.assertIn("--into", run.stderr)

    def test_a_table_is_made_once_for_each_version(self):
        for version, again, runs in (("0.7.0 (GNU)", [], 1), ("0.7.0 (GNU)", [], 1), ("0.7.0 (GNU)", ["--again"], 2),
                                     ("0.8.0 (GNU)", [], 3)):
            run = self.results("--only", "recording", *again, *self.stand_in(version))
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertEqual(read(self.path("runs")).count("x"), runs)
            self.assertEqual(rows(read(self.copy), "recording"), ["| `bench` | 1,234 | 3 us | 17 us | 500 kB |"])
            self.assertIn(f"*Made by ferrule {version} on ", block(read(self.copy), "recording"))
        listed = self.results("--list", "--into", self.copy).stdout
        self.assertRegex(listed, r"recording +timing +by ferrule 0\.8\.0 \(GNU\) on .* s on \d+ processors")

    def test_a_table_that_cannot_be_made_stays_and_the_others_are_made(self):
        run = self.results("--only", "tail,recording,turns", *self.stand_in("0.8.0"))
        self.assertEqual(run.returncode, 1)
        self.assertIn("`./ferrule bench tail --seed 1` ended with 3", run.stderr)
        self.assertIn("not made: tail, turns", run.stderr)
        self.assert_only_recording_is_made()

    def test_what_is_made_when_it_is_interrupted_is_kept(self):
        run = subprocess.Popen([sys.executable, "-B", SCRIPT, "--only", "recording,sensors", *self.stand_in("0.8.0")],
                               stderr=subprocess.PIPE, text=True, start_new_session=True,
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))
        while "bench sensors" not in run.stderr.readline():
            self.assertIsNone(run.poll())
        os.killpg(run.pid, signal.SIGINT)  # as a terminal does: a benchmark that was just begun gets it, too
        self.assertIn("stopped", run.communicate(timeout=600)[1])
        self.assertEqual(run.returncode, 130)
        self.assert_only_recording_is_made()


if __name__ == "__main__":
    main()
