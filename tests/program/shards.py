"""Shards of a job, and what ferrule merge makes of them."""

import glob
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time
from unittest import mock

from case import PROGRAM, QUICK, SOURCE, Case, ferrule, main

STRAIGHT = ("--baseline", "constant-velocity")
# Trials of some milliseconds.
JOB = ("evaluate", *STRAIGHT, "--scene", "paper", *QUICK, "--set", "ferrule.bore_diameter_um=125.4..126")


# Goes straight in. In trial 3 it ends itself by SIGNAL, the first TIMES times.
POLICY = """
import json, os, sys
for line in sys.stdin:
    asked = json.loads(line)
    if asked.get("reset", {}).get("trial") == 3 and "KILLED" in os.environ and os.path.getsize(os.environ["KILLED"]) < int(os.environ.get("TIMES", 0)):
        with open(os.environ["KILLED"], "a") as file:
            file.write("x")
        os.kill(os.getpid(), int(os.environ["SIGNAL"]))
    print(json.dumps({} if "reset" in asked else {"velocity": [-0.05, 0, 0, 0, 0]}), flush=True)
"""


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

    # All shards at once, as by Slurm's time limit, at many moments of the search, and once each on its own.
    def expect_finished_after_interruptions(self, *job, count=2, rounds=12, longest=1.0):
        chance = random.Random(7)
        for _ in range(rounds):
            processes = [self.start(index, count, *job) for index in range(1, count + 1)]
            time.sleep(chance.uniform(0.05, longest))
            for process in processes:
                process.send_signal(chance.choice((signal.SIGTERM, signal.SIGINT)))
            for process in processes:
                _, said = process.communicate(timeout=60)
                self.assertIn(process.returncode, (0, 130, -signal.SIGTERM, -signal.SIGINT), said)  # before it hears
        processes = [self.start(index, count, *job) for index in range(1, count + 1)]
        for process in processes:
            _, said = process.communicate(timeout=300)
            self.assertEqual(process.returncode, 0, said)

    def test_an_interrupted_search_is_finished(self):
        job = ("improve", "tuned_by_hand", "--scene", "paper", *QUICK, "--trials", 3000, "--unseen", 20)
        self.expect_finished_after_interruptions(*job)
        better = self.path("better.json")
        found = [(self.done(*command, "--out", better).stdout, open(better).read())
                 for command in (job, ("merge", self.job))]
        self.assertEqual(*found)

    def test_an_interrupted_map_is_finished(self):
        job = ("map", "constant-velocity", "limits.force_uN=0.1..10:log", "start.lateral_sd_um=0.1..10", "--scene",
               "paper", *QUICK, "--trials", 100, "--width", 0.25, "--target", 0.5)
        self.expect_finished_after_interruptions(*job)
        self.assertEqual(self.done("merge", self.job, "--json").stdout, self.done(*job, "--json").stdout)

    def test_interrupted_trials_are_finished(self):
        for job in (("sweep", "constant-velocity", "limits.force_uN=1,3,10", "--scene", "paper", *QUICK, "--trials", 400),
                    ("sensitivity", "constant-velocity", "--scene", "paper", *QUICK, "--trials", 100),
                    (*JOB, "--target", 0.5, "--trials", 2000)):
            self.job = self.path(job[0])
            self.expect_finished_after_interruptions(*job, rounds=5, longest=0.6)
            self.assertEqual(self.done("merge", self.job, "--json").stdout, self.done(*job, "--json").stdout)

    # A learner that was cut short is not kept as if it had learned.
    def test_an_interrupted_comparison_is_finished(self):
        episodes = self.path("episodes")
        self.record(episodes, episodes=4)
        job = ("compare", episodes, "--trials", 20, "--learners", "linear,insertion", "--seeds", "1,2")
        self.expect_finished_after_interruptions(*job, rounds=8)
        self.assertEqual(without_times(json.loads(self.done("merge", self.job, "--json").stdout)),
                         without_times(json.loads(self.done(*job, "--json").stdout)))

    # Also where the hand goes on after success: what comes then is part of the episode.
    def test_interrupted_and_killed_recordings_are_finished(self):
        chance = random.Random(26)
        job = ("record", "--scene", "paper", *QUICK, "--episodes", 40)
        whole = self.path("whole")
        table = self.done(*job, "--out", whole, "--csv").stdout
        for _ in range(40):
            process = self.start(1, 1, *job)
            time.sleep(chance.uniform(0.02, 0.3))
            process.send_signal(chance.choice((signal.SIGTERM, signal.SIGTERM, signal.SIGKILL)))
            if process.wait() == 0:
                break
        self.shard(1, 1, *job)
        for file in sorted(glob.glob(whole + "/*.h5")):
            name = os.path.basename(file)
            self.assertEqual(open(file, "rb").read(), open(f"{self.job}/{name}", "rb").read(), name)
        self.assertEqual(self.done("merge", self.job, "--csv").stdout.replace(self.job, whole), table)
        self.assertEqual(len(glob.glob(self.job + "/episode_*")), 40)

    def test_a_folder_has_several_names(self):
        job = ("record", "--scene", "paper", *QUICK, "--episodes", 4)
        whole = self.done(*job, "--out", self.job).stdout
        for file in glob.glob(self.job + "/*"):
            os.remove(file)
        other = self.path("other")
        os.symlink(self.job, other)
        self.shard(1, 2, *job)
        self.shard(2, 2, *job, out=other)
        self.assertEqual(self.done("merge", other).stdout, whole)

    # By the system, where memory is short: that says nothing of the trial, which is run again.
    def test_a_policy_that_is_killed_is_no_failed_trial(self):
        policy, killed = self.path("policy.py"), self.path("killed")
        with open(policy, "w") as file:
            file.write(POLICY)
        job = ("evaluate", "--scene", "paper", *QUICK, "--set", "limits.speed_um_s=200", "--trials", 6, "--threads", 1,
               "--policy", f"{sys.executable} {policy}")
        for how, ending in (("9", "9"), ("15", "15"), ("9", "shell")):
            command = [*job[:-1], ("" if ending == "shell" else "exec ") + job[-1]]
            self.job = self.path("job" + ending)
            environment = {"env": dict(os.environ, SIGNAL=how, TIMES="1", KILLED=killed)}
            open(killed, "w").close()
            for index in (1, 2):
                self.shard(index, 2, *command, **environment)
            self.assertEqual(open(killed).read(), "x")
            merged = self.done("merge", "--programs", self.job, "--json").stdout
            self.assertNotIn("ended the policy", merged)
            self.assertEqual(merged, self.done(*command, "--json", env=dict(os.environ, TIMES="0", KILLED=killed)).stdout)
        open(killed, "w").close()
        often = {"env": dict(os.environ, SIGNAL="9", TIMES="99", KILLED=killed)}
        self.job = self.path("often")
        for command in ((*job, "--json"), (*job, "--shard", "2/2", "--out", self.job)):
            run = ferrule(*command, **often)
            self.assertEqual((run.returncode, run.stdout), (2, ""))
            self.assertIn("trial 3: the system ended the policy: signal 9, each of 3 times", run.stderr)
        self.shard(2, 2, *job, env=dict(os.environ, TIMES="0", KILLED=killed))  # the job goes on
        # One that ends by itself has failed.
        own = {"env": dict(os.environ, SIGNAL="11", TIMES="99", KILLED=killed)}
        self.assertIn("the policy ended (exit code 139)", self.done(*job, **own).stderr)

    # A controller that ships, a folder of a policy's, and what it has in folders.
    def test_what_a_name_stands_for_must_not_change(self):
        program, data = self.path("bin/ferrule"), self.path("share/ferrule")
        os.mkdir(os.path.dirname(program))
        shutil.copy(PROGRAM, program)
        shutil.copytree(SOURCE + "/data", data)
        patch = mock.patch("case.PROGRAM", program)
        patch.start()
        self.addCleanup(patch.stop)
        policy = self.path("policy")
        os.makedirs(policy + "/weights")
        for name in ("__main__.py", "weights/first"):
            with open(f"{policy}/{name}", "w") as file:
                file.write(POLICY)
        trials = ("--scene", "bench", *QUICK, "--trials", 4)
        for name, changed, job in (("search", data + "/controllers/search.json", ("evaluate", "search", *trials)),
                                   ("bench", data + "/scenes/bench.json", ("evaluate", "search", *trials)),
                                   (policy, policy + "/weights/first",
                                    ("evaluate", *trials, "--policy", f"{sys.executable} {policy}"))):
            self.job = self.path("job_of_" + os.path.basename(changed))
            self.shard(1, 2, *job)
            text = open(changed).read()
            with open(changed, "a") as file:
                file.write("\n")
            for command in ((*job, "--shard", "2/2", "--out", self.job), ("merge", self.job)):
                self.refused(2, *command, says=[name + " has changed since the job was begun"])
            with open(changed, "w") as file:
                file.write(text)
            self.shard(2, 2, *job)

    # A folder of a stranger's.
    def test_what_is_no_file_of_a_shard(self):
        job = (*JOB, "--trials", 10)
        self.shard(1, 2, *job)
        precious, second = self.path("precious"), self.job + "/shard_0002_of_0002.trials"
        with open(precious, "w") as file:
            file.write("precious")
        for make in (lambda: os.symlink(precious, second), lambda: shutil.copy(precious, second),
                     lambda: os.mkfifo(second), lambda: os.symlink("/dev/zero", second)):
            make()
            self.refused(3, *job, "--shard", "2/2", "--out", self.job, says=[second])
            self.assertEqual(open(precious).read(), "precious")
            os.remove(second)
        for make in (os.mkfifo, lambda name: os.symlink("/dev/zero", name)):
            make(second)
            self.refused(3, "merge", self.job, says=[second, "not a regular file"], timeout=30)
            os.remove(second)
        with open(second, "wb") as file:  # 200000 heads of blocks that have the rest of the file
            for i in range(200000):
                file.write(b"FRB1" + (12 * (199999 - i)).to_bytes(4, "little") + bytes(4))
        begin = time.time()
        self.refused(3, "merge", self.job, says=[second, "damaged"], timeout=120)
        self.assertLess(time.time() - begin, 60)
        os.remove(second)
        self.shard(2, 2, *job)
        self.done("merge", self.job)

    def test_as_many_shards_as_there_are_numbers(self):
        job = (*JOB, "--trials", 2)
        self.shard(3000000000, 3000000000, *job)
        self.refused(3, "merge", self.job, says=["shards 1/3000000000, 2/3000000000", "and 2999999991 more are not whole"], timeout=30)

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

    # As Finder leaves them, in the folder of the job and in that of the episodes.
    def test_hidden_files_of_other_systems_change_nothing(self):
        episodes = self.path("episodes")
        self.record(episodes, episodes=4)
        job = ("compare", episodes, "--trials", 3, "--learners", "linear")
        self.shard(1, 2, *job)
        for left in (episodes + "/.DS_Store", episodes + "/._episode_0001.h5", self.job + "/.DS_Store",
                     self.job + "/._shard_0001_of_0002.trials"):
            with open(left, "wb") as file:
                file.write(b"\0\5\x16\7" * 1000)
        self.shard(2, 2, *job)
        self.assertNotIn("damaged", self.done("merge", self.job).stderr)

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

    def strange(self, *command):
        """A folder as it may come from others: a whole job whose job.json holds another command."""
        if not os.path.exists(self.job):
            self.shard(1, 1, *JOB, "--trials", 2)
        with open(self.job + "/job.json") as file:
            job = json.load(file)
        with open(self.job + "/job.json", "w") as file:
            json.dump({**job, "command": [str(word) for word in command], "read": {}}, file)

    def test_a_folder_of_others_runs_no_program_and_writes_nothing(self):
        made = self.path("made")
        touch = f"touch {made}"
        weights = self.path("stranger.pt")
        with open(weights, "w") as file:
            file.write("code")
        programs = [(*JOB[:1], *JOB[3:], "--trials", 2, "--policy", touch),
                    (*JOB[:1], *JOB[3:], "--trials", 2, "--policy=" + touch),
                    ("evaluate", weights, "--trials", 2), ("sweep", weights, "limits.force_uN=1,3"),
                    ("compare", self.job, weights, "--trials", 2)]
        for command in programs:
            self.strange(*command)
            for how in ((), ("--json",), ("--watch",)):
                self.refused(2, "merge", self.job, *how, says=["runs a program", "--programs"])
        others = [("submit", "--now", "--shards", 1, "--out", made, "--", *JOB), ("merge", self.job),
                  ("view", "--out", made, "--no-open"), ("export-episodes", self.job, "--csv", made),
                  ("report", "x.json", "--out", made), ("demo",), ("no such verb",), ("--version",)]
        for command in others:
            self.strange(*command)
            self.refused(2, "merge", self.job, says=["job.json: ", "is no verb of a job"])
        writing = [(*JOB, "--trials", 2, "--report", made), (*JOB, "--trials", 2, f"--trials-out={made}"),
                   ("sweep", "constant-velocity", "limits.force_uN=1,3", "--plot", made + ".svg"),
                   ("improve", "search", "--out", made), (*JOB, "--trials", 2, "--json"),
                   ("record", "--episodes", 1, "--out", made), ("record", "--episodes", 1, f"--out={made}")]
        for command in writing:
            self.strange(*command)
            self.refused(2, "merge", self.job, says=["writes to its own folder alone"])
        self.assertFalse(os.path.exists(made))

    # The word of whoever merges is enough; submit has it from whoever submits.
    def test_programs_of_a_job_run_when_the_merge_says_so(self):
        job = ("evaluate", "--scene", "paper", *QUICK, "--trials", 4, "--policy",
               """while read q; do echo '{"velocity":[-0.01,0,0,0,0]}'; done""")
        self.shard(1, 1, *job)
        self.refused(2, "merge", self.job, "--json", says=["while read q"])
        self.assertEqual(self.done("merge", "--programs", self.job, "--json").stdout, self.done(*job, "--json").stdout)
        self.assertEqual(self.done("merge", self.job, "--json", "--programs").stdout, self.done(*job, "--json").stdout)
        for words, runs in ((job, True), (JOB, False)):
            self.done("submit", "--out", self.path("slurm"), "--shards", 1, "--", *words)
            with open(self.path("slurm/merge.sh")) as script:
                self.assertEqual(" --programs" in script.read(), runs)

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
