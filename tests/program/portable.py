import glob
import json
import os
import re
import subprocess
import sys

from case import QUICK, SOURCE, Case, ferrule, main

# The C library's functions as on an x86-64 processor of before 2013.
PLAIN = dict(os.environ, GLIBC_TUNABLES="glibc.cpu.hwcaps=-FMA,-AVX2,-FMA4,-AVX512F")
SOME = "import math; print([f(0.1 * n) for f in (math.exp, math.sin, math.atan) for n in range(1000)])"
SHIPPED = ("adhesive", "bench", "demo", "dry", "epoxy", "film", "laser", "paper", "sloppy", "sticky", "tight",
           "tolerance")
INEXACT = ("exp|exp2|expm1|log|log2|log10|log1p|pow|cbrt|hypot|sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|asinh"
           "|acosh|atanh|erf|erfc|tgamma|lgamma")


class Portable(Case):
    """The same bits whatever the processor has."""

    @classmethod
    def setUpClass(cls):
        here, plain = (subprocess.run([sys.executable, "-c", SOME], capture_output=True, env=env,
                                      check=True).stdout for env in (None, PLAIN))
        cls.differ = here != plain

    def setUp(self):
        super().setUp()
        if not self.differ:
            self.skipTest("the C library computes the same on this processor as on a plain one")

    def same(self, *arguments):
        here, plain = (self.done(*arguments, env=env).stdout for env in (None, PLAIN))
        self.assertEqual(here, plain, arguments)
        return here

    def test_forces_and_contact(self):
        for scene in SHIPPED:
            self.same("forces", "--scene", scene, "--gap-nm", "1:200:60:log", "--json")
        self.same("forces", "--scene", "demo", "--tilt-mrad", 1, "--json")
        self.same("contact", "--lambda", 0.7, "--curve", "--json")

    def test_recordings_in_every_scene(self):
        for scene in SHIPPED:
            arguments = ["record", "--scene", scene, *QUICK, "--episodes", 1, "--skill", 0.4]
            here, plain = self.path(scene), self.path(scene + "-plain")
            self.done(*arguments, "--out", here)
            self.done(*arguments, "--out", plain, env=PLAIN)
            for file in sorted(os.listdir(here)):
                with open(f"{here}/{file}", "rb") as a, open(f"{plain}/{file}", "rb") as b:
                    self.assertTrue(a.read() == b.read(), file)
                self.same("replay", f"{here}/{file}", "--verify", "--json")

    def test_laws(self):
        out, law = self.path("out"), self.path("law.json")
        self.record(out, episodes=4)
        for kind in ("insertion", "linear", "saturated"):
            self.done("fit", out, "--law", kind, "--out", law)
            self.same("evaluate", law, "--scene", "paper", *QUICK, "--trials", 20, "--supervise",
                      "--baseline", "constant-velocity", "--json")
        for scene in ("bench", "epoxy", "tolerance"):
            self.same("evaluate", "--scene", scene, *QUICK, "--baseline", "constant-velocity",
                      "--trials", 10, "--json")

    def test_networks(self):
        out, policy = self.path("out"), self.path("policy.json")
        self.record(out, episodes=4)
        run = ferrule("fit", out, "--method", "torch", "--ensemble", 2, "--out", policy)
        if run.returncode == 2 and "libtorch-dev" in run.stderr:
            self.skipTest("built without libtorch")
        self.same("evaluate", policy, "--scene", "paper", *QUICK, "--trials", 10, "--supervise",
                  "--json")

    def test_search_spiral_and_what_is_improved(self):
        for scene in ("bench", "ladder/c", "ladder/f"):
            self.same("evaluate", "search", "--scene", scene, "--baseline", "spiral", "--trials", 10, "--json")
        files = []
        for env in (None, PLAIN):
            files.append(self.path("improved.json"))
            self.done("improve", "tuned_by_hand", "--scene", "bench", *QUICK, "--trials", 1000, "--trials-each", 5, "--unseen", 10,
                      "--out", files[-1], env=env)
            with open(files[-1]) as file:
                files[-1] = json.load(file)
        self.assertEqual(*files)

    def test_plans_fits_and_scores(self):
        def but_costs(item):
            if isinstance(item, dict):
                return {k: but_costs(v) for k, v in item.items() if k != "cost_ns"}
            return list(map(but_costs, item)) if isinstance(item, list) else item

        plans = [json.loads(self.done("plan", "--scene", "paper", "--tolerance", 0.05, "--json", env=env).stdout)
                 for env in (None, PLAIN)]
        self.assertEqual(*map(but_costs, plans))
        out = self.path("out")
        self.record(out, episodes=4)
        # Ceres takes powers of the C library: the last digits of a fit may differ.
        here, plain = (json.loads(self.done("fit", out, "--law", "insertion", "--out", self.path("law.json"), "--json",
                                            env=env).stdout)["gains"] for env in (None, PLAIN))
        self.assertEqual(here.keys(), plain.keys())
        for name, gain in here.items():
            for key in ("value", "low", "high"):
                if gain[key] is None:
                    self.assertIsNone(plain[name][key])
                else:
                    self.assertAlmostEqual(gain[key], plain[name][key], delta=1e-10 * abs(gain[key]), msg=name)
        self.same("score", out, "--json")


class Sources(Case):
    """What is simulated, recorded, learned or evaluated calls no function that differs from processor to processor."""

    def test_they_call_those_of_elementary_hpp(self):
        call = re.compile(rf"(?:\bstd::|(?<![\w:.>]))(?:{INEXACT})\((?!\))")
        for folder in ("sim", "haptic", "insertion", "capture", "learn", "controller"):
            for file in glob.glob(f"{SOURCE}/{folder}/**/*.[ch]*", recursive=True):
                name = os.path.relpath(file, SOURCE)
                # Their definitions; C for who has only its own library; libtorch, which is of each processor anyway.
                if re.search(r"/elementary\.|controller/c_header|/torch_", name):
                    continue
                with open(file) as source:
                    lines = source.read().splitlines()
                self.assertEqual([(name, n, line) for n, line in enumerate(lines, 1)
                                  if call.search(line.partition("//")[0])], [])


if __name__ == "__main__":
    main()
