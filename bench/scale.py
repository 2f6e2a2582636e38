"""Time and memory against trials, episodes, rows and learners: the table of docs/scale.md.

usage: scale.py PROGRAM [WHAT | WHAT=N,N ...]
"""

import glob
import math
import os
import subprocess
import sys
import tempfile
import time

STRAIGHT = ("--baseline", "constant-velocity", "--scene", "paper", "--set", "start.distance_um=10", "--set",
            "success.depth_um=8", "--set", "limits.speed_um_s=20", "--set", "start.lateral_sd_um=4")
LEARNERS = ("linear", "insertion", "phased", "saturated")


def run(program, *words):
    """Seconds, and the most memory [MB]."""
    begin = time.monotonic()
    process = subprocess.Popen([program, *map(str, words)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"{' '.join(map(str, words))}: ended with status {status}")
    return time.monotonic() - begin, used.ru_maxrss / 1024


class Tasks:
    """Each method: what is done with `n` of something in an empty folder, and how many they are."""

    def __init__(self, program, folder):
        self.program, self.folder = program, folder

    def run(self, *words):
        return run(self.program, *words)

    def recording(self, episodes, *more, out="episodes"):
        return "record", "--scene", "bench", "--episodes", episodes, "--out", f"{self.folder}/{out}", *more

    def record(self, episodes, *more):
        return self.run(*self.recording(episodes, *more))

    def slow(self, n):
        return "--set", f"limits.speed_um_s={10 / n}", "--set", "limits.time_s=3600"

    def trials_in_one_process(self, n):
        return n, self.run("evaluate", *STRAIGHT, "--trials", n)

    def trials_in_a_shard(self, n):
        return n, self.run("evaluate", *STRAIGHT, "--trials", n, "--shard", "1/1", "--out", self.folder + "/job")

    def trials_merged(self, n):
        self.trials_in_a_shard(n)
        return n, self.run("merge", self.folder + "/job")

    def episodes_recorded(self, n):
        return n, self.record(n)

    def episodes_fitted(self, n):
        self.record(n)
        return n, self.run("fit", self.folder + "/episodes", "--out", self.folder + "/law.json")

    def episodes_scored(self, n):
        self.record(n)
        return n, self.run("score", self.folder + "/episodes")

    # One episode, n times as long.
    def rows_recorded(self, n):
        used = self.record(1, *self.slow(n))
        return self.rows(), used

    # With the verb: on one episode.
    def on_one_episode(self, n, *words):
        self.rows_recorded(n)
        return self.rows(), self.run(words[0], self.folder + "/episodes", *words[1:])

    def rows_replayed_and_verified(self, n):
        return self.on_one_episode(n, "replay", "--verify")

    def rows_scored(self, n):
        return self.on_one_episode(n, "score")

    def rows_recovered(self, n):
        self.rows_recorded(n)
        rows, size = self.rows_and_bytes()
        journal = self.folder + "/killed/episode_0001.part"
        process = subprocess.Popen([self.program, *map(str, self.recording(1, *self.slow(2 * n), out="killed"))],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while not os.path.exists(journal) or os.path.getsize(journal) < size:
            time.sleep(0.01)
        process.kill()
        process.wait()
        return rows, self.run("recover", self.folder + "/killed")

    def rows_and_bytes(self):
        import h5py
        (file,) = glob.glob(self.folder + "/episodes/*.h5")
        with h5py.File(file) as episode:
            demo = episode["data/demo_0"]
            return len(demo["time"]), 8 * sum(table.size for table in (*demo["rows"].values(), demo["states"]))

    def rows(self):
        return self.rows_and_bytes()[0]

    def learners_compared(self, n):
        self.record(8)
        return n, self.run("compare", self.folder + "/episodes", "--trials", 100, "--learners", ",".join(LEARNERS[:n]))


SIZES = {"trials_in_one_process": (1000, 10000, 100000), "trials_in_a_shard": (1000, 10000, 100000),
         "trials_merged": (1000, 10000, 100000), "episodes_recorded": (4, 16, 64), "episodes_fitted": (16, 64),
         "episodes_scored": (4, 16, 64), "rows_recorded": (1, 2, 4), "rows_recovered": (1, 2, 4),
         "rows_replayed_and_verified": (1, 2, 4), "rows_scored": (1, 2, 4), "learners_compared": (1, 2, 4)}


def exponent(sizes, values):
    if len(sizes) < 2:
        return "-"
    return f"{math.log(values[-1] / values[-2]) / math.log(sizes[-1] / sizes[-2]):.2f}"


def main(program, chosen):
    print("| what | how many | time [s] | memory [MB] | grows with the power |\n|---|---|---|---|---|")
    for what in chosen or SIZES:
        name, _, given = what.partition("=")
        sizes, times, memories = [], [], []
        for n in map(int, given.split(",")) if given else SIZES[name]:
            with tempfile.TemporaryDirectory() as folder:
                size, (seconds, memory) = getattr(Tasks(program, folder), name)(n)
            sizes.append(size)
            times.append(seconds)
            memories.append(memory)
        cells = [", ".join(f"{value:.3g}" for value in values) for values in (times, memories)]
        print(f"| {name.replace('_', ' ')} | {', '.join(map(str, sizes))} | {' | '.join(cells)} | "
              f"time {exponent(sizes, times)}, memory {exponent(sizes, memories)} |", flush=True)


main(os.path.abspath(sys.argv[1]), sys.argv[2:])
