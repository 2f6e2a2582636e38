"""Policies of somebody else's: programs behind a pipe, and TorchScript."""

import json
import sys

from case import SOURCE, Case, main

# The same admittance everywhere, in the hand's world.
STEP = """
def answer(q):
    fx, fy, fz = q["wrench"][:3]
    return {"velocity": [-2e-3 + 4e-4 * fx, 9e-4 * fy, 9e-4 * fz, 0, 0]}
"""
LOOP = """
import json, sys
for line in sys.stdin:
    q = json.loads(line)
    print(json.dumps({} if "reset" in q else answer(q)), flush=True)
"""


class Foreign(Case):
    def evaluate(self, program, *more):
        file = self.path("policy.py")
        with open(file, "w") as out:
            out.write(program)
        done = self.done("evaluate", "--scene", "bench", "--policy", f"{sys.executable} {file}",
                         "--policy-hz", "20", "--json", *more)
        return json.loads(done.stdout), done.stderr

    def test_any_number_of_threads_gives_the_same(self):
        one, _ = self.evaluate(STEP + LOOP, "--trials", "4", "--threads", "1")
        two, _ = self.evaluate(STEP + LOOP, "--trials", "4", "--threads", "2")
        self.assertEqual(one["rows"], two["rows"])
        self.assertGreater(one["successes"], 0)

    def test_one_that_dies_disturbs_no_other_trial(self):
        whole, _ = self.evaluate(STEP + LOOP, "--trials", "4")
        dying = STEP + LOOP.replace("q = json.loads(line)", """q = json.loads(line)
    if q.get("reset", {}).get("trial") == 2: sys.exit(7)""")
        trials = self.path("trials.csv")
        some, stderr = self.evaluate(dying, "--trials", "4", "--trials-out", trials)
        self.assertEqual(some["outcomes"]["invalid_output"], 1)
        self.assertEqual(some["successes"], whole["successes"] - 1)
        self.assertIn("1 of 4 trials: the policy ended (exit code 7)", stderr)
        self.assertIn("exit code 7", open(trials).read())
        self.assertEqual(some["rows"][0]["failures"], {"the policy ended (exit code 7)": 1})

    def test_what_a_hostile_one_does_is_told(self):
        for answer, reason in [
            ("print(json.dumps({'velocity': [1, 2]}), flush=True)", 'no {"velocity"'),
            ("print(json.dumps({'velocity': [1, 2, 3, 4, 'x']}), flush=True)", 'no {"velocity"'),
            ("print('nonsense', flush=True)", "no JSON"),
            ("print('{}\\n{}', flush=True)", "more than it was asked"),
            ("sys.stdout.write('x' * 100000); sys.stdout.flush()", "65536 bytes"),
            ("import time; time.sleep(30)", "did not answer within"),
            ("sys.stdout.close(); os.close(1); import time; time.sleep(30)", "did not answer"),
            ("print(json.dumps({'velocity': [float('nan')] * 5}), flush=True)", "no JSON"),
            ("os.kill(os.getpid(), 9)", "the policy ended ("),
        ]:
            program = "import json, os, sys\nsys.stdin.readline()\nprint('{}', flush=True)\n" + \
                      "for line in sys.stdin:\n    " + answer + "\n"
            found, stderr = self.evaluate(program, "--trials", "1", "--policy-timeout", "2")
            self.assertEqual(found["outcomes"]["invalid_output"], 1, answer)
            self.assertIn(reason, stderr, answer)
        slow = LOOP.replace("for line", "import time\nfor line").replace("print(", "time.sleep(0.2 * ('wrench' in q)); print(")
        found, stderr = self.evaluate(STEP + slow, "--trials", "1", "--policy-timeout", "0.1")
        self.assertIn("did not answer within 0.1 s", stderr)
        supervised, stderr = self.evaluate("", "--trials", "2", "--supervise")
        self.assertEqual(supervised["outcomes"]["gave_up"], 2)
        self.assertIn("2 of 2 trials: the policy ended", stderr)

    def test_torchscript_answers_like_a_program(self):
        try:
            import torch
        except ImportError:
            self.skipTest("no torch")

        class Admittance(torch.nn.Module):
            def forward(self, x):
                v = torch.zeros(1, 5, dtype=torch.float64)
                f = x.to(torch.float64)
                v[0, 0] = -2e-3 + 4e-4 * f[0, 0]
                v[0, 1] = 9e-4 * f[0, 1]
                v[0, 2] = 9e-4 * f[0, 2]
                return v

        file = self.path("policy.pt")
        torch.jit.script(Admittance()).save(file)
        done = self.done("evaluate", file, "--scene", "bench", "--trials", "4", "--policy-hz", "20",
                         "--json")
        program, _ = self.evaluate(STEP + LOOP, "--trials", "4")
        found = json.loads(done.stdout)
        self.assertEqual(found["outcomes"], program["outcomes"])
        self.assertAlmostEqual(found["time_s"]["median"], program["time_s"]["median"], delta=0.1)
        with open(self.path("broken.pt"), "wb") as out:
            out.write(b"no module")
        self.refused(3, "evaluate", self.path("broken.pt"), says=("TorchScript",))

        class Short(torch.nn.Module):
            def forward(self, x):
                return x[:, :2]

        torch.jit.script(Short()).save(self.path("short.pt"))
        self.refused(3, "evaluate", self.path("short.pt"), says=("2 numbers, not 5",))

    def test_compare_takes_them_beside_the_learners(self):
        folder = self.path("episodes")
        self.done("record", "--scene", "bench", "--episodes", "3", "--seed", "1", "--out", folder)
        program = self.path("policy.py")
        with open(program, "w") as out:
            out.write(STEP + LOOP)
        tuned = SOURCE + "/data/controllers/tuned_by_hand.json"
        command = f"{sys.executable} {program}"
        done = self.done("compare", folder, tuned, "--learners", "linear", "--policy", command,
                         "--policy-hz", "20", "--trials", "4", "--json")
        rows = {row["controller"]: row for row in json.loads(done.stdout)["rows"]}
        self.assertEqual(rows[tuned]["outcomes"], rows["tuned by hand"]["outcomes"])
        self.assertAlmostEqual(rows[tuned]["time_s"]["median"],
                               rows["tuned by hand"]["time_s"]["median"], 9)
        self.assertIsNone(rows[tuned]["fit_s"])
        alone, _ = self.evaluate(STEP + LOOP, "--trials", "4")
        for key in ("outcomes", "time_s", "peak_force_uN"):
            self.assertEqual(rows[command][key], alone[key])
        self.refused(2, "compare", folder, tuned, tuned, says=("twice",))
        self.refused(3, "compare", folder, self.path("nowhere.json"), says=("nowhere.json",))


if __name__ == "__main__":
    main()
