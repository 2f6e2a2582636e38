"""Shards of a job, and what ferrule merge makes of them."""

import glob
import json
import os
import random
import resource
import signal
import subprocess
import sys
import time

from case import PROGRAM, QUICK, Case, ferrule, main

STRAIGHT = ("--baseline", "constant-velocity")
# Trials of some milliseconds.
JOB = ("evaluate", *STRAIGHT, "--scene", "paper", *QUICK, "--set", "ferrule.bore_diameter_um=125.4..126")


class Shards(Case):
    def setUp(self):
        super().setUp()
        self.job = self.path("job")

    def shard(self, index, count, *job, out=None, **options):
        return self.done(*job, "--shard", f"{index}/{count}", "--out", out or self.job, **options)

    def start(self, index, count, *job):
        process = subprocess.Popen([PROGRAM, *map(str, job), "--shard", f"{index}/{count}", "--out", self.job],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    # What each shard prints is not what is found.
    def expect_merged(self, count, *job):
        for index in range(count, 0, -1):
            self.assertEqual(self.shard(index, count, *job).stdout,
                             f"shard {index}/{count} is whole; when all are: ferrule merge {self.job}\n")
        for how in ((), ("--json",), ("--csv",)):
            self.assertEqual(self.done("merge", self.job, *how).stdout, self.done(*job, *how).stdout, how)

    def test_trials_of_evaluate_are_those_of_one_process(self):
        job = (*JOB, "--trials", 61, "--supervise")
        self.expect_merged(4, *job)
        page, table = self.path("page.html"), self.path("trials.csv")
        files = []
        for command in (job, ("merge", self.job)):
            self.done(*command, "--report", page, "--trials-out", table)
            files.append([open(file).read() for file in (page, table)])
        self.assertEqual(*files)

    def test_a_target_is_reached_after_the_same_trials(self):
        self.expect_merged(2, *JOB, "--target", 0.5, "--trials", 2000)

    def test_points_of_a_sweep(self):
        self.expect_merged(3, "sweep", "constant-velocity", "limits.force_uN=1,3,10", "--scene", "paper", *QUICK,
                           "--trials", 20)

    def test_what_is_drawn_again_for_sensitivity(self):
        self.expect_merged(2, "sensitivity", "constant-velocity", "--scene", "paper", *QUICK, "--trials", 20)

    # Which points come next depends on those before: the shards run at once.
    def test_points_of_a_map(self):
        job = ("map", "constant-velocity", "limits.force_uN=0.1..10:log", "start.lateral_sd_um=0.1..10", "--scene",
               "paper", *QUICK, "--trials", 20, "--width", 0.25, "--target", 0.5)
        for process in [self.start(index, 2, *job) for index in (1, 2)]:
            self.assertEqual(process.wait(timeout=300), 0)
        self.assertEqual(self.done("merge", self.job, "--json").stdout, self.done(*job, "--json").stdout)

    def test_gains_are_improved(self):
        job = ("improve", "tuned_by_hand", "--scene", "paper", *QUICK, "--trials", 1500, "--unseen", 20)
        for process in [self.start(index, 2, *job) for index in (1, 2)]:
            self.assertEqual(process.wait(timeout=300), 0)
        better = self.path("better.json")
        found = [(self.done(*command, "--out", better).stdout, open(better).read())
                 for command in (job, ("merge", self.job))]
        self.assertEqual(*found)

    # Once killed: what it left is recorded again, and so is what was not kept.
    def test_episodes_are_recorded(self):
        job = ("record", "--scene", "paper", *QUICK, "--episodes", 5)
        whole = self.done(*job, "--out", self.job).stdout
        files = {file: open(file, "rb").read() for file in glob.glob(self.job + "/*")}
        self.assertEqual(len(files), 5)
        for file in files:
            os.remove(file)
        self.shard(1, 2, *job)
        self.refused(3, "merge", self.job, says=["shard 2/2 is not whole"])
        for left in ("episode_0002.part", "episode_0004.h5"):
            with open(f"{self.job}/{left}", "w") as file:
                file.write("left")
        self.shard(2, 2, *job)
        self.assertEqual(self.done("merge", self.job + "/").stdout, whole)
        for file, content in files.items():
            self.assertEqual(open(file, "rb").read(), content, file)
        self.assertEqual(glob.glob(self.job + "/*.part"), [])

    # Learned once, by the shard that needs it first; times are measured, and differ.
    def test_learners_are_compared(self):
        episodes = self.path("episodes")
        self.record(episodes, episodes=4)
        job = ("compare", episodes, "--trials", 6, "--learners", "linear", "--seeds", "1,2", "--transfer", "paper")
        for index in (1, 2):
            self.shard(index, 2, *job)
        learned = glob.glob(self.job + "/learned/*/controller.json")
        self.assertEqual(len(learned), 3)
        self.assertEqual(without_times(json.loads(self.done("merge", self.job, "--json").stdout)),
                         without_times(json.loads(self.done(*job, "--json").stdout)))

    # Killed, interrupted and begun again at random; damaged once. Nothing that was whole is run twice.
    def test_nothing_is_lost_by_kills(self):
        chance = random.Random(45)
        kills, trials = (500, 400000) if os.environ.get("FERRULE_LONG") else (8, 10000)
        job = (*JOB, "--trials", trials, "--threads", 1)
        shards = {1, 2, 3}
        kept = dict.fromkeys(shards, 0)
        for _ in range(kills):
            if not shards:
                break
            index = chance.choice(sorted(shards))
            process = self.start(index, 3, *job)
            time.sleep(chance.uniform(0.05, 1.5))  # a block is written every second
            process.send_signal(chance.choice((signal.SIGKILL, signal.SIGKILL, signal.SIGTERM)))
            if process.wait() == 0:
                shards.remove(index)
            file = f"{self.job}/shard_000{index}_of_0003.trials"
            if os.path.exists(file):
                size = os.path.getsize(file)
                self.assertGreaterEqual(size, kept[index])
                kept[index] = size
        self.shard(2, 3, *job, timeout=3600)  # so that a whole block follows: a last one is cut off, not damaged
        file = self.job + "/shard_0002_of_0003.trials"
        with open(file, "r+b") as damaged:
            damaged.seek(os.path.getsize(file) // 2)
            byte = damaged.read(1)
            damaged.seek(-1, os.SEEK_CUR)
            damaged.write(bytes([byte[0] ^ 1]))
        for index in (1, 2, 3):
            self.shard(index, 3, *job, timeout=3600)
        merged = self.done("merge", self.job, "--json")
        self.assertEqual(merged.stdout, self.done(*job, "--json", timeout=3600).stdout)
        self.assertIn("a part of it is damaged", merged.stderr)

    def test_trials_that_are_there_twice_are_told_and_count_once(self):
        job = (*JOB, "--trials", 12)
        for index, count in ((1, 1), (2, 3)):
            self.shard(index, count, *job)
        merged = self.done("merge", self.job, "--json")
        self.assertIn("4 trials are there twice, and count once", merged.stderr)
        self.assertEqual(merged.stdout, self.done(*job, "--json").stdout)

    def test_gaps_are_named(self):
        job = (*JOB, "--trials", 30)
        self.refused(3, "merge", self.job, says=["job.json"])
        for index in (1, 3):
            self.shard(index, 3, *job)
        self.refused(3, "merge", self.job, says=["shard 2/3 is not whole", "20 of 30 trials"])
        self.shard(2, 3, *job)
        file = self.job + "/shard_0002_of_0003.trials"
        content = open(file, "rb").read()
        second = content.index(b"FRB1", 1)
        with open(file, "wb") as damaged:  # the trials, but not that the shard is whole
            damaged.write(content[:second + 20] + b"x" + content[second + 21:])
        run = ferrule("merge", self.job, "--json")
        self.assertEqual((run.returncode, run.stdout), (3, ""))
        self.assertIn("10 trials are missing", run.stderr)
        self.assertIn("run shard 2/3 again", run.stderr)

    def test_what_does_not_belong_together_is_refused(self):
        controller = self.path("controller.json")
        self.done("improve", "tuned_by_hand", "--scene", "paper", *QUICK, "--trials", 1000, "--unseen", 1, "--out", controller)
        job = ("evaluate", controller, "--trials", 10)
        self.shard(1, 2, *job)
        self.refused(2, "evaluate", controller, "--trials", 11, "--shard", "2/2", "--out", self.job,
                     says=["is another job", "--trials 10"])
        text = open(controller).read()
        with open(controller, "a") as file:
            file.write("\n")
        for command in ((*job, "--shard", "2/2", "--out", self.job), ("merge", self.job)):
            self.refused(2, *command, says=["controller.json has changed since"])
        with open(controller, "w") as file:
            file.write(text)
        self.shard(2, 2, *job)
        with open(self.job + "/job.json") as file:
            described = json.load(file)
        described["version"] = "0.1.0"
        with open(self.job + "/job.json", "w") as file:
            json.dump(described, file)
        for command in ((*job, "--shard", "2/2", "--out", self.job), ("merge", self.job)):
            self.refused(2, *command, says=["was begun by ferrule 0.1.0"])
        for broken in ("[]", "{}", '{"command": [1]}', "{"):
            with open(self.job + "/job.json", "w") as file:
                file.write(broken)
            for command in ((*job, "--shard", "2/2", "--out", self.job), ("merge", self.job)):
                self.refused(2, *command, says=["job.json"])

    def test_options_are_refused_in_one_line(self):
        job = (*JOB, "--trials", 2)
        for shard in ("0/2", "3/2", "2", "x/y", "1/", "-1/2"):
            self.refused(2, *job, f"--shard={shard}", "--out", self.job, says=["must be I/N"])
        self.refused(2, *job, "--shard", "1/2", says=["--out"])
        self.refused(2, *job, "--out", self.job, says=["--shard"])
        self.refused(2, *job, "--json", "--shard", "1/2", "--out", self.job, says=["--json: is for ferrule merge"])
        self.shard(1, 1, *job)
        self.refused(2, "merge", self.job, "--trials", 3, says=["--trials"])
        self.refused(2, "merge", self.job, "--plot", "a.svg", says=["--plot"])

    def test_two_with_the_same_number_do_not_write_to_one_file(self):
        job = (*JOB, "--trials", 100000)
        process = self.start(1, 2, *job)
        while not glob.glob(self.job + "/*.trials"):
            time.sleep(0.01)
        self.refused(3, *job, "--shard", "1/2", "--out", self.job, says=["another process is writing to it"])
        process.kill()

    def test_a_folder_that_cannot_be_written(self):
        folder = self.path("file")
        open(folder, "w").close()
        self.refused(3, *JOB, "--trials", 2, "--shard", "1/2", "--out", folder + "/job", says=["file/job"])

    def test_a_shard_that_cannot_be_written(self):
        os.makedirs(self.job + "/shard_0001_of_0001.trials")
        self.refused(3, *JOB, "--trials", 2, "--shard", "1/1", "--out", self.job,
                     says=["shard_0001_of_0001.trials: Is a directory"])

    # As on a full disk: what was written before it was full is good.
    def test_a_full_disk_loses_nothing(self):
        job = (*JOB, "--trials", 10000)
        file = self.job + "/shard_0001_of_0001.trials"
        process = self.start(1, 1, *job)
        while not os.path.exists(file) or os.path.getsize(file) < 10000:
            time.sleep(0.01)
        process.kill()
        process.wait()
        kept = open(file, "rb").read()

        def little_room():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (len(kept) + 1000, resource.RLIM_INFINITY))

        self.refused(3, *job, "--shard", "1/1", "--out", self.job, preexec_fn=little_room, says=["File too large"])
        self.assertEqual(open(file, "rb").read(len(kept)), kept)
        self.shard(1, 1, *job)
        self.assertEqual(open(file, "rb").read(len(kept)), kept)
        self.assertEqual(self.done("merge", self.job, "--json").stdout, self.done(*job, "--json").stdout)

    def test_a_watch_waits_until_all_are_whole(self):
        job = (*JOB, "--trials", 40)
        self.shard(1, 2, *job)
        watch = subprocess.Popen([PROGRAM, "merge", self.job, "--watch", "--json"], stdout=subprocess.PIPE,
                                 stderr=subprocess.PIPE, text=True)
        self.addCleanup(watch.kill)
        self.assertIn("20 of 40 trials, 1 of 2 shards whole", watch.stderr.readline())
        self.shard(2, 2, *job)
        found, _ = watch.communicate(timeout=60)
        self.assertEqual(watch.returncode, 0)
        self.assertEqual(found, self.done(*job, "--json").stdout)


def without_times(value):
    if isinstance(value, dict):
        return {key: without_times(item) for key, item in value.items() if key not in ("ns_per_action", "fit_s")}
    return [without_times(item) for item in value] if isinstance(value, list) else value


main()
