import os
import re
import shutil
import subprocess
import sys

from case import PROGRAM, QUICK, SOURCE, Case, ferrule, main


class StrangeFolder(Case):
    """A folder in which others have put files that look like modules of Python."""

    def test_python_imports_nothing_of_the_folder(self):
        made, package = self.path("made"), self.path("package/ferrule")
        self.done("record", "--scene", "paper", *QUICK, "--episodes", 1, "--out", self.path("here/episodes"))
        os.makedirs(package)
        # What the program runs stands in for the package, and imports as much as that does.
        open(package + "/__init__.py", "w").close()
        with open(package + "/export_episodes.py", "w") as module:
            module.write("import json, os, signal, sys, tempfile, subprocess, multiprocessing\n"
                         "def main():\n  print('exported', sys.argv[1:])\n  return 0\n")
        evil = f"open({made!r}, 'a').write(__name__ + ' ')\n"
        for name in ("signal", "json", "os", "sys", "tempfile", "subprocess", "multiprocessing", "sitecustomize"):
            with open(self.path(f"here/{name}.py"), "w") as module:
                module.write(evil)
        os.mkdir(self.path("here/ferrule"))
        for name in ("__init__", "export_episodes"):
            with open(self.path(f"here/ferrule/{name}.py"), "w") as module:
                module.write(evil)
        pythons = [python for python in ("/usr/bin/python3", shutil.which("python3"), sys.executable) if python]
        for python in sorted(set(pythons)):
            environment = {**os.environ, "FERRULE_PYTHON": python, "PYTHONPATH": self.path("package")}
            run = self.done("export-episodes", "episodes", "--csv", "tables", cwd=self.path("here"), env=environment)
            self.assertIn("exported", run.stdout)
        self.assertFalse(os.path.exists(made), "imported: " + (open(made).read() if os.path.exists(made) else ""))


class BareNames(Case):
    """Output files named without a folder, in the folder where the program runs."""

    def test_every_output_file(self):
        here = {"cwd": self.folder}
        self.done("record", "--scene", "paper", *QUICK, "--episodes", 3, "--out", "episodes", **here)
        self.done("fit", "episodes", "--out", "law.json", "--plot", "law.svg", **here)
        self.done("evaluate", "law.json", "--trials", 2, "--trials-out", "trials.csv", "--report",
                  "trials.html", **here)
        self.done("compare", "episodes", "--learners", "linear", "--trials", 2, "--trials-out",
                  "compared.csv", **here)
        self.done("replay", "episodes/episode_0001.h5", "--csv", "--plot", "episode.svg", **here)
        self.done("export", "law.json", "--header", "law.h", **here)
        for name in ("law.json", "law.svg", "trials.csv", "trials.html", "compared.csv",
                     "episode.svg", "law.h"):
            self.assertGreater(os.path.getsize(self.path(name)), 0, name)


class Usage(Case):
    def test_wrong_usage_is_one_line_and_code_2(self):
        for arguments in ([], ["dance"], ["forces", "--gap"], ["record"], ["record", "--skill", "2",
                          "--out", "x"], ["evaluate"], ["fit", "x"], ["evaluate", "--trials", "0",
                          "--baseline", "constant-velocity"], ["record", "--episodes", "many",
                          "--out", "x"], ["evaluate", "--baseline", "hope"]):
            self.refused(2, *arguments)

    def test_the_nearest_of_what_is_known_is_named(self):
        for arguments, says in (
                (["evalute"], 'unknown verb "evalute": did you mean evaluate?'),
                (["evaluate", "--trails", 20, "--baseline", "constant-velocity"],
                 'unknown option "--trails": did you mean --trials?'),
                (["evaluate", "--baseline=constant-velocity", "--trails=20"],
                 'unknown option "--trails": did you mean --trials?'),
                # It explains what is missing.
                (["fit", "x", "--ouf", "law.json"], 'unknown option "--ouf": did you mean --out?'),
                (["--verson"], 'unknown option "--verson": did you mean --version?'),
                (["evaluate", "--baseline", "constant_velocity"], "did you mean constant-velocity?"),
                (["fit", "x", "--out", "y", "--method", "cires"], "did you mean ceres?"),
                (["compare", "x", "--learners", "linear,insertoin"], "did you mean insertion?"),
                (["forces", "--form", "corected"], "did you mean corrected?")):
            self.refused(2, *arguments, says=[says])
        self.refused(3, "forces", "--scene", "bnech", says=["did you mean bench?"])
        self.refused(3, "doctor", "--device", "pan", says=["did you mean pen?"])
        for arguments in (["dance"], ["evaluate", "--quietly"]):
            run = ferrule(*arguments)
            self.assertIn("unknown", run.stderr)
            self.assertNotIn("did you mean", run.stderr)

    def test_help_groups_the_verbs(self):
        groups = dict(re.findall(r"^(\S.*):\n((?:  [a-z].*\n)+)", self.done("--help").stdout, re.M))
        self.assertEqual(list(groups), ["The job", "Answers for an engineer", "Physics", "Devices",
                                        "Data"])
        verbs = {name: re.findall(r"^  ([a-z-]+) ", text, re.M) for name, text in groups.items()}
        self.assertIn("evaluate", verbs["The job"])
        self.assertIn("limits", verbs["Answers for an engineer"])
        self.assertIn("doctor", verbs["Devices"])
        self.assertEqual(sum(map(len, verbs.values())), 29)

    def test_completion_knows_the_verbs(self):
        words = subprocess.run(
            ["bash", "-c", '. "$0"; COMP_WORDS=("$1" "") COMP_CWORD=1; _ferrule; echo "${COMPREPLY[@]}"',
             SOURCE + "/cmake/completion.bash", PROGRAM], capture_output=True, text=True,
            check=True).stdout.split()
        self.assertEqual(words[:2], ["--help", "--version"])
        for verb in ("demo", "evaluate", "limits", "export-episodes"):
            self.assertIn(verb, words)
        self.assertEqual(len(words), 31)

    def test_an_option_that_is_given_twice_is_named(self):
        for again in (["forces", "--scene", "demo", "--scene", "paper"],
                      ["forces", "--gap-nm", 1, "--gap-nm", 2],
                      ["evaluate", "--trials=2", "--trials=2"]):
            name = again[1].split("=")[0]
            self.refused(2, *again, says=[f"ferrule: {name}: is given more than once\n"])
        self.done("forces", "--set", "laws.adhesion=null", "--set", "laws.friction=null")

    def test_numbers_are_decimal(self):
        for option, value in (("--trials", "0x10"), ("--trials", "010"), ("--trials", "1e3"),
                              ("--threads", "0x10"), ("--threads", "1.5"), ("--threads", "-1"),
                              ("--threads", "4097"), ("--policy-hz", "0x10")):
            self.refused(2, "evaluate", "--baseline", "constant-velocity", f"{option}={value}",
                         says=[f"ferrule: {option}: must be a", f"not {value} "])
        self.refused(2, "forces", "--gap-nm", "0x10", says=["--gap-nm 0x10"])
        self.refused(2, "view", "--port", 70000, says=["--port", "65535"])

    def test_help_and_version(self):
        text = self.done("--help").stdout
        for verb in ("demo", "scene", "forces", "contact", "release", "limits", "plan", "record", "recover", "replay",
                     "score", "fit", "improve", "identify", "evaluate", "compare", "sweep", "map", "sensitivity", "report",
                     "export", "bench", "devices", "doctor"):
            self.assertIn(verb, text)
            help = self.done(verb, "--help").stdout
            self.assertGreaterEqual(help.count("\n  ferrule " + verb), 2, verb)
        self.assertRegex(self.done("--version").stdout, r"^\d+\.\d+\.\d+ ")

    def test_a_file_without_end_is_not_read(self):
        self.refused(3, "forces", "--scene", "/dev/zero")
        self.refused(3, "doctor", "--device", "/dev/zero")

    def test_a_full_output_is_noticed(self):
        with open("/dev/full", "w") as full:
            run = subprocess.run([PROGRAM, "forces", "--json"], stdout=full, stderr=subprocess.PIPE)
        self.assertEqual(run.returncode, 3)
        self.assertIn(b"standard output cannot be written", run.stderr)

    # As other programs do: 141 is what a shell makes of SIGPIPE.
    def test_a_reader_that_has_enough_ends_it_quietly(self):
        for arguments in (["forces", "--gap-nm", "1:500:50000"],
                          ["forces", "--gap-nm", "1:500:50000", "--json"],
                          ["forces", "--gap-nm", "1:500:50000", "--csv"], ["scene"]):
            process = subprocess.Popen([PROGRAM, *arguments], stdout=subprocess.PIPE,
                                       stderr=subprocess.PIPE)
            process.stdout.close()
            self.assertEqual(process.stderr.read(), b"")
            process.stderr.close()
            self.assertEqual(process.wait(), 141, arguments)


if __name__ == "__main__":
    main()
