"""Signals: every verb hears one, and no process is left behind."""

import glob
import json
import os
import signal
import subprocess
import sys
import time

from case import PROGRAM, SOURCE, Case, main

# Ignores that its input ends.
STUBBORN = """
import os, signal, sys, time
signal.signal(signal.SIGTERM, signal.SIG_IGN)
with open(sys.argv[1] + "/" + str(os.getpid()), "w"):
    pass
time.sleep(600)
"""


class Signals(Case):
    def start(self, *arguments, **options):
        options = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, **options}
        process = subprocess.Popen([PROGRAM, *map(str, arguments)], **options)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    # Each of these takes minutes, or has no end.
    def test_work_of_every_kind_hears_a_signal(self):
        episodes = self.path("episodes")
        self.record(episodes, episodes=4)
        slow = ("--set", "limits.speed_um_s=0.01", "--set", "limits.time_s=3600")
        for arguments in (("evaluate", "--baseline", "constant-velocity", "--trials", 100000, *slow),
                          ("evaluate", "--policy", "sleep 600", "--trials", 2),
                          ("plan", "--scene", "bench", "--tolerance", 1e-6),
                          ("doctor", "--seconds", 3600),
                          ("identify", episodes, "--parameters",
                           "laws.friction.burgers_nm,ferrule.bore_diameter_um,fibre.density_kg_m3"),
                          ("record", "--episodes", 100000, "--append", "--out", self.path("more")),
                          ("compare", episodes, "--trials", 1000000, "--learners", "linear"),
                          ("demo", "--out", self.path("demo"), *slow)):
            for which in (signal.SIGINT, signal.SIGTERM):
                process = self.start(*arguments)
                time.sleep(0.5)
                self.assertIsNone(process.poll(), arguments)
                process.send_signal(which)
                self.assertEqual(process.wait(timeout=20), 130, arguments)

    # What it has by then is kept.
    def test_a_benchmark_says_that_it_stops_after_a_case(self):
        process = self.start("bench", "capture", "--json", stdout=subprocess.PIPE)
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        table, said = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assertIn(b"stops after this case", said)
        self.assertIn("partial", json.loads(table)["provenance"])

    # Nobody asks there whether a signal came.
    def test_a_verb_that_waits_for_a_reader_hears_a_signal(self):
        for which in (signal.SIGINT, signal.SIGTERM):
            process = self.start("forces", "--gap-nm", "1:400:20000", "--json",
                                 stdout=subprocess.PIPE)
            process.stdout.read(1)
            time.sleep(0.5)
            self.assertIsNone(process.poll())
            process.send_signal(which)
            self.assertEqual(process.wait(timeout=20), 130)
            self.assertIn(b"stopped before the end", process.stderr.read())
            process.stdout.close()

    # Nor does it wait for a reader itself.
    def test_a_full_standard_error_does_not_keep_it(self):
        full, end = os.pipe()
        self.addCleanup(os.close, full)
        self.addCleanup(os.close, end)
        os.set_blocking(end, False)
        with self.assertRaises(BlockingIOError):
            while True:
                os.write(end, b"x" * 65536)
        os.set_blocking(end, True)
        process = subprocess.Popen([PROGRAM, "forces", "--gap-nm", "1:400:20000", "--json"],
                                   stdout=subprocess.PIPE, stderr=end)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.kill)
        process.stdout.read(1)
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(timeout=20), 130)

    # The command that a test runs, and the processes of it once two are there.
    def stubborn(self):
        program = self.path("stubborn.py")
        with open(program, "w") as out:
            out.write(STUBBORN)
        pids = self.path("pids")
        os.mkdir(pids)
        return f"cd / && {sys.executable} {program} {pids}", pids

    def started(self, pids):
        while len(os.listdir(pids)) < 2:
            time.sleep(0.05)
        return os.listdir(pids)

    def assert_gone(self, pids):
        def lives(pid):
            try:
                return open(f"/proc/{pid}/stat").read().rsplit(")")[1].split()[0] != "Z"
            except FileNotFoundError:
                return False
        for _ in range(200):
            if not any(map(lives, pids)):
                return
            time.sleep(0.05)
        self.fail("processes are left")

    def test_a_policy_does_not_outlive_the_program(self):
        for end in (signal.SIGKILL, signal.SIGINT, None):
            command, pids = self.stubborn()
            timeout = 0.1 if end is None else 600
            process = self.start("evaluate", "--policy", command, "--policy-timeout", timeout,
                                 "--trials", 2, "--threads", 2)
            found = self.started(pids)
            if end:
                process.send_signal(end)
            process.wait(timeout=60)
            self.assert_gone(found)
            for file in (*glob.glob(pids + "/*"), self.path("stubborn.py")):
                os.remove(file)
            os.rmdir(pids)


if __name__ == "__main__":
    main()
