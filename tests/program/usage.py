import os
import re
import shutil
import subprocess

from case import PROGRAM, SOURCE, Case, ferrule, main


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
        self.assertEqual(sum(map(len, verbs.values())), 21)

    def test_completion_knows_the_verbs(self):
        words = subprocess.run(
            ["bash", "-c", '. "$0"; COMP_WORDS=("$1" "") COMP_CWORD=1; _ferrule; echo "${COMPREPLY[@]}"',
             SOURCE + "/cmake/completion.bash", PROGRAM], capture_output=True, text=True,
            check=True).stdout.split()
        self.assertEqual(words[:2], ["--help", "--version"])
        for verb in ("demo", "evaluate", "limits", "export-episodes"):
            self.assertIn(verb, words)
        self.assertEqual(len(words), 23)

    def test_help_and_version(self):
        text = self.done("--help").stdout
        for verb in ("demo", "scene", "forces", "contact", "release", "limits", "plan", "record", "recover", "replay",
                     "score", "fit", "identify", "evaluate", "compare", "export", "bench", "devices",
                     "doctor"):
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

    def test_the_start_script_names_missing_packages(self):
        tools = self.path("bin")
        os.mkdir(tools)
        with open(tools + "/dpkg-query", "w") as out:
            out.write("#!/bin/sh\necho installed g++\nexit 1\n")
        os.chmod(tools + "/dpkg-query", 0o755)
        clone = self.path("clone")
        os.mkdir(clone)
        shutil.copy(SOURCE + "/ferrule", clone)
        run = subprocess.run([clone + "/ferrule", "demo"], capture_output=True, text=True,
                             env={**os.environ, "FERRULE_NO_INSTALL": "1",
                                  "PATH": tools + ":" + os.environ["PATH"]})
        self.assertEqual(run.returncode, 3)
        self.assertEqual(run.stdout, "")
        self.assertIn("missing packages:", run.stderr)
        self.assertIn("libceres-dev", run.stderr)
        self.assertNotIn("g++", run.stderr)


if __name__ == "__main__":
    main()
