"""Shards on a cluster: Slurm, of one node that this test starts itself, and the recipes of docs/scale.md."""

import os
import random
import re
import socket
import subprocess
import sys
import time

from case import PROGRAM, QUICK, SOURCE, Case, ferrule, main

JOB = ("evaluate", "--baseline", "constant-velocity", "--scene", "paper", *map(str, QUICK))
CONFIGURATION = """ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmdPort={port_of_node}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SchedulerParameters=sched_interval=1,batch_sched_delay=0
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MaxArraySize=2001
SwitchType=switch/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
ReturnToService=2
KillWait=2
NodeName={host} NodeAddr=127.0.0.1 CPUs={cores} State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def free_port():
    with socket.socket() as any_port:
        any_port.bind(("127.0.0.1", 0))
        return any_port.getsockname()[1]


class Slurm(Case):
    def setUp(self):
        super().setUp()
        if os.geteuid() != 0:
            self.skipTest("Slurm is started as root")
        for name in ("state", "spool"):
            os.mkdir(self.path(name))
        with open(self.path("munge.key"), "wb") as key:
            os.fchmod(key.fileno(), 0o600)
            key.write(os.urandom(1024))
        with open(self.path("slurm.conf"), "w") as file:
            file.write(CONFIGURATION.format(host=socket.gethostname(), folder=self.folder, port=free_port(),
                                            port_of_node=free_port(), cores=os.cpu_count()))
        self.environment = {**os.environ, "SLURM_CONF": self.path("slurm.conf")}
        self.daemon("munged", "--foreground", "--force", "--key-file=" + self.path("munge.key"),
                    *(f"--{what}-file=" + self.path("munge." + what) for what in ("pid", "log", "seed")),
                    "--socket=" + self.path("munge.socket"))
        self.comes(lambda: os.path.exists(self.path("munge.socket")))
        self.daemon("slurmctld", "-D")
        self.daemon("slurmd", "-D", "-N", socket.gethostname())
        self.comes(lambda: "idle" in self.run_here("sinfo", "-h").stdout)

    def daemon(self, *words):
        process = subprocess.Popen(words, env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)

    def run_here(self, *words):
        return subprocess.run(words, env=self.environment, cwd=self.folder, capture_output=True, text=True)

    def comes(self, what, seconds=60):
        until = time.time() + seconds
        while not what():
            self.assertLess(time.time(), until)
            time.sleep(0.1)

    def queue(self):
        return self.run_here("squeue", "-h", "-o", "%i").stdout.split()

    # Killed, requeued and cancelled at random; what is missing then is submitted again.
    def test_a_thousand_shards_with_kills_are_as_one_process(self):
        chance = random.Random(45)
        job = (*JOB, "--trials", "20000")
        submitted = self.run_here(PROGRAM, "submit", "--out", "job", "--shards", "1000", "--now", "--", *job, "--json")
        self.assertEqual(submitted.returncode, 0, submitted.stderr)
        self.assertIn("1000 shards, each with a node of its own", submitted.stdout)
        array = re.search(r"(\d+)", self.run_here("squeue", "-h", "-r", "-o", "%F").stdout)[1]
        for kill in range(50):
            time.sleep(chance.uniform(0, 3))
            if kill % 3 == 0:
                found = self.run_here("pgrep", "-f", "--", "--shard .* --out job").stdout.split()
                for process in found[:1]:
                    self.run_here("kill", "-9", process)
            elif kill % 3 == 1:
                running = self.run_here("squeue", "-h", "-r", "-t", "R", "-o", "%A").stdout.split()
                for task in running[:1]:
                    self.run_here("scontrol", "requeue", task)
            else:
                self.run_here("scancel", f"{array}_{chance.randint(1, 1000)}")
        self.comes(lambda: not self.queue(), seconds=3000)
        merged = self.run_here(PROGRAM, "merge", "job", "--json")
        while merged.returncode != 0:
            self.assertEqual(merged.returncode, 3, merged.stderr)
            left = [i for i in range(1, 1001) if b"done" not in self.content(i)]
            self.assertTrue(left)
            again = self.run_here("sh", "job/submit.sh", "--array=" + ",".join(map(str, left)))
            self.assertEqual(again.returncode, 0, again.stderr)
            self.comes(lambda: not self.queue(), seconds=1000)
            merged = self.run_here(PROGRAM, "merge", "job", "--json")
        alone = self.run_here(PROGRAM, *job, "--json").stdout
        self.assertEqual(merged.stdout, alone)
        with open(self.path("job/result")) as result:  # of the last merge that Slurm ran
            self.assertEqual(result.read(), alone)

    def content(self, shard):
        try:
            with open(self.path(f"job/shard_{shard:04}_of_1000.trials"), "rb") as file:
                return file.read()
        except FileNotFoundError:
            return b""

    def test_an_array_larger_than_slurm_takes_is_refused(self):
        refused = self.run_here(PROGRAM, "submit", "--out", "job", "--shards", "2001", "--", *JOB)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("an array of Slurm has at most 2000 here", refused.stderr)

    def test_a_job_is_measured_and_divided(self):
        written = self.run_here(PROGRAM, "submit", "--out", "job", "--nodes", "3", "--partition", "all", "--", *JOB,
                                "--trials", "100000000")
        self.assertEqual(written.returncode, 0, written.stderr)
        self.assertIn("100000000 trials of", written.stdout)
        with open(self.path("job/array.sh")) as file:
            script = file.read()
        self.assertRegex(script, r"#SBATCH --array=1-\d+%3\n")
        self.assertIn("#SBATCH --partition=all\n", script)
        self.assertEqual(sorted(os.listdir(self.path("job"))), ["array.sh", "merge.sh", "submit.sh"])


class Recipes(Case):
    """Blocks of docs/scale.md, each in a folder with ./ferrule."""

    def setUp(self):
        super().setUp()
        with open(SOURCE + "/docs/scale.md") as file:
            self.blocks = re.findall(r"```\w*\n(.*?)```", file.read(), re.DOTALL)
        os.symlink(PROGRAM, self.path("ferrule"))

    def block(self, begin):
        found = [block for block in self.blocks if block.startswith(begin)]
        self.assertEqual(len(found), 1, begin)
        self.assertLessEqual(found[0].count("\n"), 20)
        return found[0].replace("1000000", "300")

    def run_here(self, command):
        run = subprocess.run(command, shell=True, cwd=self.folder, capture_output=True, text=True, timeout=600)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        return run.stdout

    def expect_result(self, text):
        alone = ferrule("evaluate", "search", "--scene", "bench", "--trials", "300", cwd=self.folder).stdout
        self.assertTrue(text.endswith(alone), text)

    def test_parallel(self):
        self.expect_result(self.run_here(self.block("parallel").replace("--sshloginfile hosts", "--sshlogin :")))

    def test_snakemake(self):
        with open(self.path("Snakefile"), "w") as file:
            file.write(self.block("rule"))
        self.run_here("snakemake --cores 2")
        with open(self.path("result.txt")) as file:
            self.expect_result(file.read())

    def test_submitit(self):
        self.run_here(f"{sys.executable} -m venv env && env/bin/pip install -q -r {SOURCE}/python/requirements-scale.txt")
        with open(self.path("recipe.py"), "w") as file:
            file.write(self.block("import").replace("AutoExecutor(", 'AutoExecutor(cluster="local", '))
        self.expect_result(self.run_here("env/bin/python recipe.py"))


if __name__ == "__main__":
    main()
