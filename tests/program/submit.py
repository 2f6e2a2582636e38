"""ferrule submit, with a Slurm that is set up in one way or another."""

import json
import os
import shlex
import stat
import subprocess

from case import PROGRAM, QUICK, Case, ferrule, main

JOB = ("evaluate", "constant-velocity", "--scene", "paper", *QUICK, "--trials", 12)
# Says what it was asked, and what it is to say, and keeps where it was asked. A task of the array, and the
# merge, find what Slurm gives them.
SBATCH = """#!/bin/sh
{ pwd; for word; do printf '%s\\n' "$word"; done; } >"$CALLS/$(ls "$CALLS" | wc -l)"
eval "$SAYS"
"""


class Submitted(Case):
    def setUp(self):
        super().setUp()
        for name in ("bin", "calls"):
            os.mkdir(self.path(name))

    def tool(self, name, script):
        with open(self.path("bin/" + name), "w") as out:
            out.write(script)
        os.chmod(self.path("bin/" + name), 0o755)

    def here(self, says="", **more):
        return {"cwd": self.folder, "env": {**os.environ, "PATH": self.path("bin") + ":" + os.environ["PATH"],
                                            "CALLS": self.path("calls"), "SAYS": says}, **more}

    def calls(self):
        found = []
        for name in sorted(os.listdir(self.path("calls")), key=int):
            with open(self.path("calls/" + name)) as call:
                found.append(call.read().split("\n"))
        return found

    def slurm(self, config="", says="echo 41"):
        self.tool("scontrol", f"#!/bin/sh\ncat <<'end'\n{config}\nend\n")
        self.tool("sbatch", SBATCH)
        return self.here(says)

    def submit(self, out, *more, job=JOB, **how):
        return ferrule("submit", "--out", out, "--shards", 3, *more, "--", *job, **how)

    # What Slurm runs: each task, then the merge.
    def run_scripts(self, folder, shards=3):
        for index in range(1, shards + 1):
            run = subprocess.run(["sh", folder + "/array.sh"], cwd="/", capture_output=True, text=True,
                                 env={**os.environ, "SLURM_ARRAY_TASK_ID": str(index)})
            self.assertEqual(run.returncode, 0, run.stderr)
        run = subprocess.run(["sh", folder + "/merge.sh"], cwd="/", capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stderr)
        return run.stdout

    def test_folders_of_any_name_get_the_logs_and_the_result(self):
        alone = self.done(*JOB).stdout
        slurm = self.slurm()
        for name in ("plain", "of %j and %a", "back\\slash", "it's \"quoted\"", "two\nlines", "#SBATCH --x", "$HOME`id`",
                     "f\udcfcr alle"):
            folder = os.path.join(os.fsdecode(os.fsencode(self.folder)), name)
            before = len(self.calls_raw())
            run = subprocess.run([PROGRAM, "submit", "--out", name, "--shards", "3", "--now", "--", *map(str, JOB)],
                                 capture_output=True, **slurm)
            self.assertEqual(run.returncode, 0, (name, run.stderr))
            # Slurm knows the folder as the one it was called in, and by no name that it would change.
            for call in self.calls_raw()[before:]:
                self.assertTrue(call.startswith(os.fsencode(os.path.realpath(folder)) + b"\n--"), (name, call))
            for script in ("array.sh", "merge.sh"):
                with open(os.path.join(folder, script), "rb") as file:
                    directives = [line for line in file.read().split(b"\ncd ")[0].split(b"\n")[1:]]
                for line in directives:
                    self.assertRegex(line, rb"^#SBATCH --[a-z-]+(=[\w.,%-]+)?$")
            self.assertEqual(self.run_scripts(folder), alone, name)

    def calls_raw(self):
        found = []
        for name in sorted(os.listdir(self.path("calls")), key=int):
            with open(self.path("calls/" + name), "rb") as call:
                found.append(call.read())
        return found

    def test_the_merge_waits_for_the_array_on_its_cluster(self):
        for says, cluster, number in (("echo 41", [], "41"), ("echo '7041;far away'", ["--clusters=far away"], "7041"),
                                      ("echo Welcome to 1 cluster; echo; echo '12;b'", ["--clusters=b"], "12"),
                                      ("echo 99 nodes are down >&2; echo 5", [], "5")):
            slurm = self.slurm(says=says)
            before = len(self.calls())
            self.assertEqual(self.submit("job", "--now", **slurm).returncode, 0)
            array, merge = self.calls()[before:]
            self.assertEqual(array[1:-1], ["--parsable", "./array.sh"])
            self.assertEqual(merge[1:-1], [f"--dependency=afterany:{number}", *cluster, "./merge.sh"])

    def test_options_of_sbatch_are_those_of_the_array(self):
        slurm = self.slurm(says="echo '41;far'")
        self.submit("job", **slurm)
        run = subprocess.run(["sh", self.path("job/submit.sh"), "--array=3,7", "--account=a b"], capture_output=True,
                             **slurm)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(self.calls()[0][1:-1], ["--parsable", "--array=3,7", "--account=a b", "./array.sh"])
        self.assertEqual(self.calls()[1][1:-1], ["--dependency=afterany:41", "--clusters=far", "./merge.sh"])

    def test_what_slurm_refuses_is_told(self):
        for says, told in (("echo not now >&2; exit 1", "not now"), ("echo queued", "no number of a job: queued"),
                           ("true", "no number of a job")):
            run = self.submit("job", "--now", **self.slurm(says=says))
            self.assertEqual(run.returncode, 3)
            self.assertIn(told, run.stderr)
            self.assertIn("job/submit.sh: Slurm did not take it", run.stderr.splitlines()[-1])
        self.assertEqual(len(self.calls()), 3)  # no merge of nothing

    def test_arrays_are_as_large_as_the_site_has_them(self):
        parameters = "SchedulerParameters     = " + ",".join(f"some_parameter_{i}=1" for i in range(40))
        for config, most in (("MaxArraySize            = 1001", 1000), ("MaxArraySize = 4", 3),
                             (parameters + "\nMaxArraySize            = 5", 4), ("nothing of it", 1000),
                             (parameters + ",max_array_tasks=7\nMaxArraySize = 100001", 7),
                             ("MaxArraySize = 9\nSchedulerParameters = max_array_tasks=50", 8)):
            slurm = self.slurm(config)
            self.refused(2, "submit", "--out", self.path("job"), "--shards", most + 1, "--", *JOB,
                         says=[f"at most {most} here"], **slurm)
            self.done("submit", "--out", self.path("job"), "--shards", most, "--", *JOB, **slurm)
        for size in (0, 1):
            self.refused(2, "submit", "--out", self.path("none"), "--shards", 3, "--", *JOB,
                         says=[f"MaxArraySize = {size}", "--shard I/N"], **self.slurm(f"MaxArraySize            = {size}"))
        self.assertFalse(os.path.exists(self.path("none")))

    def test_a_partition_is_a_name(self):
        slurm = self.slurm()
        for wrong in ("a b", "a\n#SBATCH --x", '"a"', "a\\b", "a#"):
            self.assertEqual(self.submit("job", "--partition", wrong, **slurm).returncode, 2, wrong)
        self.assertEqual(self.submit("job", "--partition", "short,long", **slurm).returncode, 0)
        with open(self.path("job/array.sh")) as script:
            self.assertIn("#SBATCH --partition=short,long\n", script.read())

    # Words of the job with a line break, and with quotes; one that is not UTF-8 is refused, as job.json is.
    def test_words_of_the_job_are_kept_to_the_byte(self):
        document = json.loads(self.done("scene", "paper", "--json").stdout)["provenance"]["scene"]["document"]
        for name in ("a\nscene.json", "sc\u00e4ne's \"1\".json", "sc\udce4ne.json"):
            with open(self.path(name), "w") as scene:
                json.dump(document, scene)
            job = ("evaluate", "constant-velocity", "--scene", name, *QUICK, "--trials", "6")
            folder = self.path("job of " + str(len(name)))
            run = self.submit(folder, job=job, **self.slurm())
            if "\udce4" in name:
                self.assertEqual(run.returncode, 2)
                self.assertIn("must be UTF-8", run.stderr)
            else:
                self.assertEqual(run.returncode, 0, run.stderr)
                self.run_scripts(folder)


main()
