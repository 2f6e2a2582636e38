"""Files: what is read is not replaced, what a file system lacks, and texts of any length in episodes."""

import errno
import glob
import json
import os
import shutil
import signal
import subprocess
import time

import h5py

from case import PROGRAM, QUICK, SOURCE, Case, ferrule, main

STRAIGHT = ("--baseline", "constant-velocity", "--scene", "paper", *QUICK)


def contents(folder):
    return {file: open(file, "rb").read() for file in glob.glob(folder + "/**", recursive=True) if os.path.isfile(file)}


class Replaced(Case):
    """A file that is written would take the place of one that is read: refused before anything is done."""

    def setUp(self):
        super().setUp()
        self.episodes, self.law, self.scene = map(self.path, ("episodes", "law.json", "mine.json"))
        self.record(self.episodes, episodes=4)
        self.done("fit", self.episodes, "--out", self.law)
        for name, extends in (("base.json", "paper"), ("mine.json", "base.json")):
            with open(self.path(name), "w") as file:
                json.dump({"name": name[:-5], "extends": extends}, file)
        self.first = self.episodes + "/episode_0001.h5"

    def refuses(self, output, read, *words):
        before = contents(self.folder)
        option = words[-2] if words[-1] == output else words[words.index(output) - 1]
        self.refused(2, *words, says=[f"{option} {output}: would replace {read}"], cwd=self.folder)
        self.assertEqual(contents(self.folder), before)

    def test_what_is_named(self):
        policy, trials = self.path("policy.py"), ("--trials", 1)
        shutil.copy(SOURCE + "/examples/policy.py", policy)
        found = self.path("found.json")
        with open(found, "w") as file:
            file.write(self.done("evaluate", *STRAIGHT, *trials, "--json").stdout)
        for output, read, *words in (
                (self.law, self.law, "evaluate", self.law, *trials, "--trials-out", self.law),
                (self.law, self.law, "evaluate", self.law, *trials, "--report", self.law),
                (self.scene, self.scene, "evaluate", "search", "--scene", self.scene, *trials, "--report", self.scene),
                (policy, policy, "evaluate", "--policy", f"python3 '{policy}'", "--trials-out", policy, *trials),
                (self.law, self.law, "export", self.law, "--header", self.law),
                (self.law, self.law, "improve", self.law, "--trials", 1000, "--out", self.law),
                (self.scene, self.scene, "improve", self.law, "--also", "bench," + self.scene, "--out", self.scene),
                (self.scene, self.scene, "plan", "--scene", self.scene, "--out", self.scene),
                (found, found, "report", found, "--out", found),
                (found, found, "report", found, "--out", self.path("page.html"), "--pdf", found),
                (self.law, self.law, "sweep", self.law, "limits.force_uN=1,2", "--plot", self.path("plot.svg"))):
            if output != words[-1] and "--plot" in words:  # a plot is an .svg; by a link
                output = self.path("plot.svg")
                os.symlink(self.law, output)
            self.refuses(output, read, *words)

    def test_what_is_in_a_folder(self):
        for words in (("fit", self.episodes, "--out"), ("view", self.episodes, "--export"),
                      ("compare", self.episodes, "--trials", 1, "--trials-out"),
                      ("export-episodes", self.episodes, "--robomimic")):
            self.refuses(self.first, self.first, *words, self.first)
        self.refuses(self.first, self.first, "view", self.first, "--export", self.first)
        plot = self.path("plots/report.html")
        os.mkdir(os.path.dirname(plot))
        os.link(self.first, plot)
        before = contents(self.folder)
        self.refused(2, "compare", self.episodes, "--trials", 1, "--plot", os.path.dirname(plot), says=[plot, self.first])
        self.assertEqual(contents(self.folder), before)

    def test_what_is_named_by_what_is_named(self):
        base = self.path("base.json")
        self.refuses(base, base, "evaluate", "search", "--scene", self.scene, "--trials", 1, "--report", base)
        policy = self.path("policy.json")
        with open(policy, "w") as file:
            json.dump({"method": "torch", "weights": "policy.1.safetensors"}, file)
        weights = self.path("policy.1.safetensors")
        shutil.copy(self.law, weights)
        self.refuses(weights, weights, "export", policy, "--header", weights)

    def test_under_other_names(self):
        for make in (os.symlink, os.link):
            for read, words in ((self.law, ("evaluate", self.law, "--trials", 1, "--report")),
                                (self.first, ("view", self.episodes, "--export")),
                                (self.path("base.json"), ("plan", "--scene", self.scene, "--out"))):
                other = self.path("other")
                make(read, other)
                self.refuses(other, read, *words, other)
                os.remove(other)
        self.refuses("./episodes/../law.json", "law.json", "export", "law.json", "--header", "./episodes/../law.json")
        self.refused(2, "export", self.law, "--header=" + self.law, says=["would replace"])

    def test_what_a_job_reads(self):
        job = self.path("job")
        self.done("evaluate", self.law, "--trials", 2, "--shard", "1/1", "--out", job)
        for read in (self.law, job + "/job.json", job + "/shard_0001_of_0001.trials"):
            self.refuses(read, read, "merge", job, "--trials-out", read)
        page = job + "/page.html"
        for _ in range(2):  # its own of before is replaced
            self.done("merge", job, "--report", page)

    def test_two_outputs_in_one_place(self):
        for names in (("page",) * 2, ("page", "./page")):
            self.refused(2, "evaluate", *STRAIGHT, "--report", names[0], "--trials-out", names[1],
                         says=["--trials-out", "would replace --report page"], cwd=self.folder)
        self.done("evaluate", *STRAIGHT, "--trials", 1, "--report", "/dev/null", "--trials-out", "/dev/null")

    def test_what_is_not_read_is_replaced(self):
        for _ in range(2):
            self.done("fit", self.episodes, "--out", self.episodes + "/controller.json")
            self.done("export", self.law, "--header", self.path("law.h"))

    def test_a_shard_does_not_replace_episodes_of_others(self):
        job = ("record", "--scene", "paper", *QUICK, "--episodes", 5, "--shard", "1/2", "--out")
        before = contents(self.episodes)
        self.refused(2, *job, self.episodes, says=[self.episodes, "already holds episodes"])
        self.assertEqual(contents(self.episodes), before)
        out = self.path("job")
        self.done(*job, out)
        shutil.copy(self.first, out + "/episode_0002.h5")  # of another trial
        self.refused(2, *(word.replace("1/2", "2/2") if isinstance(word, str) else word for word in job), out,
                     says=["episode_0002.h5: is no episode of this job"])
        self.assertEqual(open(out + "/episode_0002.h5", "rb").read(), open(self.first, "rb").read())


# Each call that LACKS names, as in "flock=38,link=1", fails with that errno.
SHIM = r"""
#define _GNU_SOURCE
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>
static int lacks(const char* call) {
  const char* all = getenv("LACKS");
  const char* found = all ? strstr(all, call) : 0;
  if (!found) return 0;
  errno = atoi(found + strlen(call));
  return 1;
}
int flock(int fd, int how) { return lacks(" flock=") ? -1 : syscall(SYS_flock, fd, how); }
int fsync(int fd) { return lacks(" fsync=") ? -1 : syscall(SYS_fsync, fd); }
int fdatasync(int fd) { return lacks(" fdatasync=") ? -1 : syscall(SYS_fdatasync, fd); }
int link(const char* a, const char* b) { return lacks(" link=") ? -1 : syscall(SYS_linkat, -100, a, -100, b, 0); }
int rename(const char* a, const char* b) { return lacks(" rename=") ? -1 : syscall(SYS_renameat, -100, a, -100, b); }
int renameat2(int d, const char* a, int e, const char* b, unsigned how) {
  return lacks(" renameat2=") ? -1 : syscall(SYS_renameat2, d, a, e, b, how);
}
"""
NO_LOCKS = (errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP)
NO_LINKS = (errno.EPERM, errno.EOPNOTSUPP, errno.ENOSYS)


class Lacking(Case):
    """File systems without locks, links or a disk to wait for, as a library in between makes one of ours."""

    def setUp(self):
        super().setUp()
        self.shim = self.path("shim.so")
        subprocess.run(["cc", "-shared", "-fPIC", "-o", self.shim, "-x", "c", "-"], input=SHIM, text=True, check=True)

    def lacking(self, **calls):
        return {"timeout": 120, "env": dict(os.environ, LD_PRELOAD=self.shim, LACKS="".join(
            f" {call}={number}" for call, number in calls.items()))}

    RECORD = ("record", "--scene", "paper", *QUICK, "--episodes", 2, "--out")

    def test_episodes_are_recorded_all_the_same(self):
        whole = self.path("whole")
        self.done(*self.RECORD, whole)
        ways = [{"flock": number} for number in NO_LOCKS]
        ways += [{"link": number} for number in NO_LINKS]
        ways += [{"link": number, "renameat2": errno.EINVAL} for number in NO_LINKS]
        ways += [{"fsync": number} for number in (errno.EINVAL, errno.EROFS, errno.EOPNOTSUPP, errno.ENOSYS)]
        ways += [{"flock": errno.ENOLCK, "link": errno.EPERM, "renameat2": errno.EINVAL, "fsync": errno.EINVAL}]
        for way in ways:
            out = self.path("out")
            run = self.done(*self.RECORD, out, **self.lacking(**way))
            self.assertEqual(run.stderr.count("has no locks"), 1 if "flock" in way else 0, run.stderr)
            self.assertEqual({os.path.basename(name): content for name, content in contents(out).items()},
                             {os.path.basename(name): content for name, content in contents(whole).items()}, way)
            shutil.rmtree(out)

    def test_what_is_written_besides_episodes(self):
        episodes, law = self.path("episodes"), self.path("law.json")
        self.record(episodes, episodes=4)
        for way in ({"flock": errno.ENOSYS}, {"flock": errno.ENOLCK, "link": errno.EPERM, "fsync": errno.EINVAL}):
            self.done("fit", episodes, "--out", law, **self.lacking(**way))
            self.done("evaluate", law, "--trials", 2, "--report", self.path("page.html"), **self.lacking(**way))
        self.assertEqual(glob.glob(self.folder + "/*.tmp"), [])

    def test_a_real_error_ends_it_in_one_line(self):
        episodes, law = self.path("episodes"), self.path("law.json")
        self.record(episodes, episodes=4)
        for call, number in (("flock", errno.EIO), ("flock", errno.EBADF), ("fsync", errno.EIO), ("fsync", errno.ENOSPC),
                             ("rename", errno.EIO), ("rename", errno.EACCES)):
            self.refused(3, "fit", episodes, "--json", "--out", law, says=["law.json"],
                         **self.lacking(**{call: number}))
            self.assertEqual([name for name in os.listdir(self.folder) if name.startswith("law")], [], call)
        for calls in ({"flock": errno.EIO}, {"link": errno.EIO}, {"link": errno.ENOSPC},
                      {"link": errno.EPERM, "renameat2": errno.EINVAL, "rename": errno.EIO}, {"fsync": errno.EIO}):
            out = self.path("out")
            self.refused(3, *self.RECORD, out, "--json", says=["episode_0001"], **self.lacking(**calls))
            self.assertEqual(glob.glob(out + "/*.h5*"), [], calls)
            shutil.rmtree(out)

    def test_a_file_that_is_there_is_not_replaced(self):
        for way in ({}, {"link": errno.EPERM}, {"link": errno.EPERM, "renameat2": errno.EINVAL}):
            out = self.path("out")
            self.done(*self.RECORD, out)
            before = contents(out)
            self.done(*self.RECORD, out, "--append", **self.lacking(**way))
            self.assertEqual({name: content for name, content in contents(out).items() if name in before}, before)
            self.assertEqual(len(contents(out)), 4)
            shutil.rmtree(out)

    # Nobody can tell a recording that goes on from one that was killed.
    def test_recover_leaves_alone_what_may_still_be_recorded(self):
        out = self.path("out")
        process = subprocess.Popen([PROGRAM, "record", "--scene", "paper", "--episodes", "1000", "--out", out],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        while not any(os.path.getsize(part) > 100000 for part in glob.glob(out + "/*.part")):
            time.sleep(0.01)
        process.kill()
        process.wait()
        (part,) = [part for part in glob.glob(out + "/*.part") if os.path.getsize(part) > 100000][-1:]
        empty = out + "/episode_0999.part"
        open(empty, "w").close()
        run = self.done("recover", out, **self.lacking(flock=errno.ENOSYS))
        self.assertIn("may still be recorded, as the file system has no locks", run.stdout)
        self.assertTrue(os.path.exists(part))
        for journal in glob.glob(out + "/*.part"):
            os.utime(journal, (time.time() - 3600,) * 2)
        self.done("recover", out, **self.lacking(flock=errno.ENOSYS))
        self.assertFalse(os.path.exists(part))
        self.assertTrue(os.path.exists(empty))  # whoever waits for a key has written nothing yet

    def test_shards(self):
        job, out = ("evaluate", *STRAIGHT, "--trials", 61), self.path("job")
        way = {"flock": errno.ENOSYS, "link": errno.EOPNOTSUPP, "renameat2": errno.EINVAL, "fsync": errno.EINVAL,
               "fdatasync": errno.EINVAL}
        for index in (1, 2):
            run = self.done(*job, "--shard", f"{index}/2", "--out", out, **self.lacking(**way))
            self.assertEqual(run.stderr.count("has no locks"), 1)
        self.assertEqual(self.done("merge", out, "--json", **self.lacking(**way)).stdout, self.done(*job, "--json").stdout)
        self.refused(3, *job, "--shard", "1/2", "--out", self.path("other"), says=["shard_0001_of_0002.trials"],
                     **self.lacking(fdatasync=errno.EIO))
        self.refused(3, *job, "--shard", "1/2", "--out", self.path("another"), says=["another", "cannot be locked"],
                     **self.lacking(flock=errno.EIO))

    # What was killed left a journal, which nobody has a lock of.
    def test_a_shard_of_episodes_goes_on_after_a_kill(self):
        job, out = ("record", "--scene", "paper", "--episodes", 3), self.path("job")
        process = subprocess.Popen([PROGRAM, *map(str, job), "--shard", "1/1", "--out", out], stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL, env=self.lacking(flock=errno.ENOSYS)["env"])
        while not glob.glob(out + "/episode_0002.part"):
            time.sleep(0.01)
        process.kill()
        process.wait()
        self.done(*job, "--shard", "1/1", "--out", out, **self.lacking(flock=errno.ENOSYS))
        whole = self.path("whole")
        self.done(*job, "--out", whole)
        for file in glob.glob(whole + "/*"):
            self.assertEqual(open(file, "rb").read(), open(f"{out}/{os.path.basename(file)}", "rb").read(), file)
        self.assertEqual(glob.glob(out + "/*.part"), [])


class LongTexts(Case):
    """HDF5 has no room for 64 kB in an attribute."""

    def scene(self, **more):
        file = self.path("long.json")
        bores = [round(125.6 + 0.8 * i / 20000, 6) for i in range(20000)]
        with open(file, "w") as out:
            json.dump({"name": "long", "extends": "paper", "ferrule": {"bore_diameter_um": {"choice": bores}}, **more}, out)
        return file, bores

    def test_a_scene_with_twenty_thousand_diameters(self):
        file, bores = self.scene()
        out = self.path("out")
        self.done("record", "--scene", file, *QUICK, "--episodes", 4, "--out", out)
        first = contents(out)
        for episode in first:
            with h5py.File(episode) as f:
                was = json.loads(f.attrs["scene"])["drawn_from"]["was"]
                self.assertEqual(was["ferrule.bore_diameter_um"]["choice"], bores)
                self.assertEqual(json.loads(f["data"].attrs["env_args"])["env_kwargs"]["scene"]["name"], "long")
                self.assertEqual(f.attrs["outcome"], b"inserted")
        self.done("replay", out, "--verify")
        self.done("fit", out, "--out", self.path("law.json"))
        again = self.path("again")
        self.done("record", "--scene", file, *QUICK, "--episodes", 4, "--out", again)
        self.assertEqual(list(first.values()), list(contents(again).values()))

    def test_a_long_remark(self):
        about = "n" * 70000 + "ü"
        file, _ = self.scene(about=about)
        out = self.path("out")
        self.done("record", "--scene", file, *QUICK, "--episodes", 1, "--out", out)
        with h5py.File(out + "/episode_0001.h5") as f:
            self.assertEqual(json.loads(f.attrs["scene"])["about"], about)

    def test_one_that_was_killed_is_recovered(self):
        file, _ = self.scene()
        out = self.path("out")
        process = subprocess.Popen([PROGRAM, "record", "--scene", file, "--episodes", "1000", "--out", out],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        while not any(os.path.getsize(part) > 800000 for part in glob.glob(out + "/*.part")):
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
        process.wait()
        self.done("recover", out)
        self.assertEqual(glob.glob(out + "/*.part*"), [])
        self.done("replay", out, "--verify")


if __name__ == "__main__":
    main()
