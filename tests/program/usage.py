import os
import shutil
import subprocess

from case import PROGRAM, SOURCE, Case, main


class Usage(Case):
    def test_wrong_usage_is_one_line_and_code_2(self):
        for arguments in ([], ["dance"], ["forces", "--gap"], ["record"], ["record", "--skill", "2",
                          "--out", "x"], ["evaluate"], ["fit", "x"], ["evaluate", "--trials", "0",
                          "--baseline", "constant-velocity"], ["record", "--episodes", "many",
                          "--out", "x"], ["evaluate", "--baseline", "hope"]):
            self.refused(2, *arguments)

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
