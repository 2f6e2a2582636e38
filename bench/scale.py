"""What shards cost: the table of docs/scale.md.

usage: scale.py PROGRAM [TRIALS ...]
"""

import os
import subprocess
import sys
import tempfile
import time

JOB = ("evaluate", "--baseline", "constant-velocity", "--scene", "paper", "--set", "start.distance_um=10", "--set",
       "success.depth_um=8", "--set", "limits.speed_um_s=20", "--set", "start.lateral_sd_um=4")


def run(*words):
    """Seconds, and the most memory [MB]."""
    begin = time.monotonic()
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"{' '.join(words)}: ended with status {status}")
    return time.monotonic() - begin, used.ru_maxrss / 1024


def main(program, counts):
    print("| trials | one process | one shard | merge | on disk |\n|---|---|---|---|---|")
    for count in counts:
        with tempfile.TemporaryDirectory() as folder:
            job = (program, *JOB, "--trials", str(count))
            shared = ("--shard", "1/1", "--out", folder + "/job")
            # In turns: the machine may change meanwhile.
            alone, shard = [run(*job)], [run(*job, *shared)]
            alone.append(run(*job))
            file = folder + "/job/shard_0001_of_0001.trials"
            size = os.path.getsize(file) / count
            merge = run(program, "merge", folder + "/job")
            os.remove(file)
            shard.append(run(*job, *shared))
            cells = [f"{min(s for s, _ in runs):.2f} s, {max(m for _, m in runs):.0f} MB"
                     for runs in (alone, shard, [merge])]
            print(f"| {count} | {' | '.join(cells)} | {size:.0f} B a trial |", flush=True)


main(os.path.abspath(sys.argv[1]), [int(count) for count in sys.argv[2:]] or [1000, 10000, 100000, 300000])
