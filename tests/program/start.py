"""The start script, in a copy of the repository in which nothing is built.

FERRULE_WRITE_HELP=1 writes what --help prints into app/help, instead of comparing it.
"""

import glob
import os
import pty
import re
import shutil
import subprocess
import time

from case import PROGRAM, SOURCE, Case, ferrule, main

HELP = os.path.join(SOURCE, "app/help")
BUILDERS = ("apt-get", "dpkg-query", "sudo", "cmake", "ninja", "c++", "g++", "clang", "npm", "pip", "pip3")


def verbs():
    return re.findall(r"^  ([a-z][a-z-]*) ", ferrule("--help").stdout, re.M)


class Clone(Case):
    def setUp(self):
        super().setUp()
        leave = shutil.ignore_patterns("build*", ".git", "data")
        shutil.copytree(SOURCE, self.path("clone"), symlinks=True, ignore=leave)
        os.mkdir(self.path("bin"))

    # These scripts stand in for programs.
    def tools(self, **scripts):
        for name, script in scripts.items():
            with open(self.path("bin/" + name.replace("_", "-")), "w") as out:
                out.write("#!/bin/bash\n" + script)
            os.chmod(self.path("bin/" + name.replace("_", "-")), 0o755)

    def start(self, *arguments, **environment):
        run = subprocess.run([self.path("clone/ferrule"), *arguments], capture_output=True, text=True, cwd=self.folder,
                             timeout=60, env={**os.environ, **environment,
                                              "PATH": self.path("bin") + ":" + os.environ["PATH"]})
        return run.returncode, run.stdout, run.stderr


class Answers(Clone):
    """What needs no program is said at once: nothing is installed, nothing built, and no file made."""

    def setUp(self):
        super().setUp()
        self.tools(**dict.fromkeys(BUILDERS, f"echo \"$0 $*\" >>{self.path('called')}; exit 1\n"))

    def tearDown(self):
        self.assertFalse(os.path.exists(self.path("called")))
        self.assertFalse(glob.glob(self.path("clone/build*")))

    def test_help_is_that_of_the_program(self):
        for words in ([], *([verb] for verb in verbs())):
            for flag in ("--help", "-h"):
                code, said, usage = self.start(*words, flag)
                self.assertEqual((code, said), (0, ferrule(*words, "--help").stdout))
                self.assertEqual(usage.startswith("usage: ./ferrule VERB"), not words)
        said = self.start("evaluate", "search", "--trials", "3", "--help")[1]
        self.assertEqual(said, ferrule("evaluate", "--help").stdout)
        for word in ("test", "wheel", "playground", "package"):
            code, said, usage = self.start(word, "--help")
            self.assertEqual((code, said), (0, ""))
            self.assertIn(f"./ferrule {word}", usage)

    def test_version_is_that_of_the_program(self):
        code, said, _ = self.start("--version")
        self.assertEqual(code, 0)
        self.assertRegex(said, r"^\d+\.\d+\.\d+ \(not built yet\)\n$")
        self.assertEqual(said.split()[0], ferrule("--version").stdout.split()[0])

    def test_what_does_not_exist_is_refused_as_by_the_program(self):
        for words in ([], ["recrod"], ["evalute", "--help"], ["eval"], ["exprot-episodes"], ["sensitivty"], ["dance"],
                      ["a" * 300], ["s"], ["x=y"], ["--verson"], ["--hlep"], ["--trials"]):
            refused = ferrule(*words)
            self.assertEqual(self.start(*words), (2, "", refused.stderr), words)
            self.assertEqual(refused.returncode, 2)
        self.assertIn("did you mean record?", self.start("recrod")[2])
        self.assertIn("did you mean wheel?", self.start("weel")[2])


class Help(Case):
    """app/help has what --help prints."""

    def test_a_file_for_the_program_and_for_each_verb(self):
        texts = {"ferrule": ferrule("--help").stdout, **{verb: ferrule(verb, "--help").stdout for verb in verbs()}}
        if os.environ.get("FERRULE_WRITE_HELP"):
            shutil.rmtree(HELP, ignore_errors=True)
            os.mkdir(HELP)
            for name, text in texts.items():
                with open(f"{HELP}/{name}.txt", "w") as file:
                    file.write(text)
        self.assertEqual(sorted(os.listdir(HELP)), sorted(name + ".txt" for name in texts))
        for name, text in texts.items():
            with open(f"{HELP}/{name}.txt") as file:
                self.assertEqual(file.read(), text, "app/help is older than the program (see CONTRIBUTING.md)")


class Building(Clone):
    BUILD = """[[ $* == *ferrule_app* ]] || exit 0
echo "[1/2] one"; sleep {seconds}; echo "[2/2] two"
mkdir -p {app}; printf '#!/bin/sh\\necho "did $*"\\n' >{app}/ferrule; chmod +x {app}/ferrule
"""

    def building(self, seconds):
        self.tools(dpkg_query="shift 2; printf 'installed %s\\n' \"$@\"",
                   ninja=self.BUILD.format(seconds=seconds, app=self.path("clone/build/app")),
                   cmake="while [[ $1 != -B ]]; do shift; done; touch \"$2/build.ninja\"")

    def test_says_every_ten_seconds_how_far_it_is(self):
        self.building(21)
        code, said, progress = self.start("forces", "--json")
        self.assertEqual((code, said), (0, "did forces --json\n"))
        seconds = re.findall(r"^ferrule: building in build/: 1 of 2 files, (\d+) s$", progress, re.M)
        self.assertEqual([round(int(s), -1) for s in seconds], [10, 20], progress)

    def test_a_terminal_has_one_line(self):
        self.building(3)
        reads, writes = pty.openpty()
        run = subprocess.Popen([self.path("clone/ferrule"), "forces"], stdout=subprocess.DEVNULL, stderr=writes,
                               env={**os.environ, "PATH": self.path("bin") + ":" + os.environ["PATH"]})
        self.assertEqual(run.wait(timeout=60), 0)
        os.close(writes)
        line = r"\r\x1b\[Kferrule: building in build/: 1 of 2 files, 2 s\r\x1b\[K"
        self.assertRegex(os.read(reads, 10000).decode(), line)

    def test_a_build_that_fails_is_shown(self):
        self.building(0)
        self.tools(ninja="echo '[1/2] one'; echo 'no such header'; exit 1")
        code, said, why = self.start("forces")
        self.assertEqual((code, said), (3, ""))
        self.assertIn("no such header\nferrule: the build failed\n", why)


class Packages(Clone):
    def test_waits_for_another_apt(self):
        apt = 'echo "$*" >>calls; [[ $* != *update* || $(grep -c update calls) -gt 1 ]] && exit 0\n' \
              'echo "E: Could not get lock /var/lib/apt/lists/lock"; exit 100\n'
        self.tools(dpkg_query="exit 1", cmake="exit 1", sudo='"$@"', apt_get=apt)
        code, said, why = self.start("demo")
        self.assertEqual((code, said), (3, ""))
        self.assertIn("waiting for another apt", why)
        calls = open(self.path("calls")).read().splitlines()
        self.assertEqual(["update" in call for call in calls[:3]], [True, True, False])
        self.assertIn("DPkg::Lock::Timeout", calls[2])

    def test_names_those_that_could_not_be_installed(self):
        apt = "[[ $* == *update* ]] || { echo 'E: no network'; exit 100; }"
        self.tools(dpkg_query="exit 1", sudo='"$@"', apt_get=apt)
        code, said, why = self.start("demo")
        self.assertEqual((code, said), (3, ""))
        self.assertIn("E: no network\nferrule: the packages could not be installed\n", why)

    def test_names_missing_ones(self):
        self.tools(dpkg_query="echo installed clang; exit 1")
        code, said, why = self.start("demo", FERRULE_NO_INSTALL="1")
        self.assertEqual((code, said), (3, ""))
        self.assertIn("missing packages:", why)
        self.assertIn("libceres-dev", why)
        self.assertNotIn("clang", why)


if __name__ == "__main__":
    main()
