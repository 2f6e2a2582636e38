"""Policies of somebody else's: programs behind a pipe, and TorchScript."""

import csv
import ctypes
import json
import os
import sys

from case import SOURCE, Case, ferrule, main

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
    # The arguments that evaluate it.
    def arguments(self, program, *more):
        file = self.path("policy.py")
        with open(file, "w") as out:
            out.write(program)
        return ("evaluate", "--scene", "bench", "--policy", f"{sys.executable} {file}",
                "--policy-hz", "20", "--json", *more)

    # In every trial.
    def fails(self, reason, program, *more):
        run = ferrule(*self.arguments(program, "--trials", "2", *more))
        self.assertEqual((run.returncode, run.stdout), (2, ""), program)
        self.assertIn("failed in each of 2 trials: the policy", run.stderr)
        self.assertIn(reason, run.stderr, program)

    def evaluate(self, program, *more):
        done = self.done(*self.arguments(program, *more))
        return json.loads(done.stdout), done.stderr

    def test_any_number_of_threads_gives_the_same(self):
        one, _ = self.evaluate(STEP + LOOP, "--trials", "4", "--threads", "1")
        two, _ = self.evaluate(STEP + LOOP, "--trials", "4", "--threads", "2")
        self.assertEqual(one["rows"], two["rows"])
        self.assertGreater(one["successes"], 0)

    def test_it_is_told_how_far_the_hand_has_gone(self):
        counting = '''
import json, sys
for line in sys.stdin:
    q = json.loads(line)
    if "reset" in q:
        asked, begin, answer = 0, None, {}
    else:
        begin = q["height"] if begin is None else begin
        gone = -0.002 / 20 * asked
        if abs(q["displacement"][0] - gone) > 1e-12 or abs(q["height"] - begin - gone) > 1e-12: sys.exit(9)
        asked, answer = asked + 1, {"velocity": [-0.002, 0, 0, 0, 0]}
    print(json.dumps(answer), flush=True)
'''
        told, _ = self.evaluate(counting, "--trials", "2")
        self.assertNotIn("failures", told["rows"][0])

    # In the hand's world, that of the trial.
    def test_it_is_told_the_force_limit_and_may_say_done(self):
        stopping = STEP + LOOP.replace("answer(q)", """\\
        {"velocity": [0, 0, 0, 0, 0], "done": q["time"] >= q["force_limit"]}""")
        trials = self.path("trials.csv")
        ended, _ = self.evaluate(stopping, "--trials", "4", "--set", "limits.force_uN=20..90", "--trials-out", trials)
        self.assertEqual(ended["outcomes"]["stopped_short"], 4)
        with open(SOURCE + "/data/scenes/bench.json") as file:
            scale = json.load(file)["scaling"]
        with open(trials) as file:
            rows = list(csv.DictReader(file))
        limits = set()
        for row in rows:
            # It stopped after as many seconds as newtons, and up to a period of 20 Hz.
            uN = float(row["time_s"]) * scale["tip_force_uN"] / scale["hand_force_N"]
            self.assertTrue(20 <= uN < 90.7, uN)
            limits.add(round(uN))
        self.assertGreater(len(limits), 1)
        self.fails('"done" neither true nor false', (STEP + LOOP).replace("0, 0]}", "0, 0], 'done': 1}"))

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
            ("os.kill(os.getpid(), 11)", "the policy ended ("),
        ]:
            program = "import json, os, sys\nsys.stdin.readline()\nprint('{}', flush=True)\n" + \
                      "for line in sys.stdin:\n    " + answer + "\n"
            self.fails(reason, program, "--policy-timeout", "2")
        slow = LOOP.replace("for line", "import time\nfor line").replace("print(", "time.sleep(0.2 * ('wrench' in q)); print(")
        self.fails("did not answer within 0.1 s", STEP + slow, "--policy-timeout", "0.1")
        # As the system does where memory is short: no trial has failed by that.
        run = ferrule(*self.arguments("import os\nos.kill(os.getpid(), 9)\n", "--trials", "2"))
        self.assertEqual((run.returncode, run.stdout), (2, ""))
        self.assertIn("the system ended the policy: signal 9, each of 3 times", run.stderr)
        self.fails("the policy ended", "", "--supervise")
        self.refused(2, "evaluate", "--policy", "exec /no/such/program 2> /dev/null", "--json",
                     "--trials", 2, says=["failed in each of 2 trials: the policy ended (exit code"])

    def test_one_that_never_answers_is_not_asked_for_ever(self):
        counted = self.path("counted")
        program = f"with open({counted!r}, 'a') as out:\n    out.write('x')\nraise SystemExit(3)\n"
        run = ferrule(*self.arguments(program, "--trials", "200", "--threads", "1"))
        self.assertEqual(run.returncode, 2)
        self.assertIn("failed in each of 200 trials: the policy failed in its first 10 trials and is "
                      "asked no more: the policy ended (exit code 3)", run.stderr)
        self.assertEqual(open(counted).read(), 10 * "x")

    def test_it_may_say_why_it_cannot_answer(self):
        refusing = LOOP.replace("answer(q)", "{'error': 'no such state\\x1b[31m'}")
        self.refused(2, *self.arguments(STEP + refusing, "--trials", "1"),
                     says=["the policy failed: no such state\\x1b[31m"])

    def test_what_it_says_on_its_standard_error_is_passed_on_up_to_a_limit(self):
        talking = STEP + LOOP.replace("for line", "print('it talks', file=sys.stderr)\nfor line")
        _, stderr = self.evaluate(talking, "--trials", "1")
        self.assertEqual(stderr, "it talks\n")
        flooding = STEP + LOOP.replace("    print", "    sys.stderr.write(100000 * 'x')\n    print")
        found, stderr = self.evaluate(flooding, "--trials", "2")
        whole, _ = self.evaluate(STEP + LOOP, "--trials", "2")
        self.assertEqual(found["rows"], whole["rows"])
        self.assertEqual(stderr.count("x"), 65536)
        self.assertIn("left out", stderr)
        dying = "import sys\nsys.stdin.readline()\nraise RuntimeError('its last words')\n"
        run = ferrule(*self.arguments(dying, "--trials", "1"))
        self.assertEqual(run.returncode, 2)
        self.assertIn("its last words", run.stderr)

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

        class ByItsMotion(torch.nn.Module):  # goes on by 200 um of the tip: 30 um into the bore
            def forward(self, x):
                on = (x[0, 7] > -0.05).to(torch.float64)
                assert x.shape[1] == 13
                return torch.stack([-2e-3 * on, 0 * on, 0 * on])

        torch.jit.script(ByItsMotion()).save(self.path("motion.pt"))
        trials = self.path("trials.csv")
        self.done("evaluate", self.path("motion.pt"), "--scene", "bench", "--trials", 1, "--set", "start.lateral_sd_um=0",
                  "--set", "limits.time_s=40", "--trials-out", trials)
        with open(trials) as table:
            [row] = csv.DictReader(table)
        self.assertAlmostEqual(float(row["depth_um"]), 30, delta=0.5)

        class WithinItsLimit(torch.nn.Module):  # ends where more than half the limit presses
            def forward(self, x):
                assert x.shape[1] == 14
                return torch.tensor([-2e-3, 0.0, 0.0]), bool(x[0, :3].norm() > 0.5 * x[0, 13])

        torch.jit.script(WithinItsLimit()).save(self.path("limit.pt"))
        for limit in (20, 40):
            found = json.loads(self.done("evaluate", self.path("limit.pt"), "--scene", "bench", "--trials", 1, "--set",
                                         "sensor={}", "--set", f"limits.force_uN={limit}", "--json").stdout)
            self.assertEqual(found["outcomes"]["stopped_short"], 1)
            self.assertTrue(0.5 < found["peak_force_uN"]["median"] / limit < 0.6, found)

        class Short(torch.nn.Module):
            def forward(self, x):
                return x[:, :2]

        torch.jit.script(Short()).save(self.path("short.pt"))
        self.refused(3, "evaluate", self.path("short.pt"), says=("2 numbers, not 5",))

    def test_torchscript_that_is_hostile_does_no_harm(self):
        try:
            import torch
        except ImportError:
            self.skipTest("no torch")
        victim = self.path("victim")

        class Crashes(torch.nn.Module):
            def forward(self, x):
                return x[:, :5] * float(7 % (int(x[0, 0].item()) * 0))

        class Hangs(torch.nn.Module):
            def forward(self, x):
                n = 0
                while n >= 0:
                    n = (n + 1) % 1000
                return x

        class TakesAll(torch.nn.Module):
            def forward(self, x):
                while x.numel() > 0:
                    x = torch.cat([x, x])
                return x

        class Writes(torch.nn.Module):
            def __init__(self, file: str):
                super().__init__()
                self.file = file

            def forward(self, x):
                torch.save(x, self.file)
                return x[:, :5] * 0

        class Maps(Writes):
            def forward(self, x):
                return x[:, :5] * 0 + torch.from_file(self.file, True, 5).fill_(1.0)

        with open(victim, "w") as out:
            out.write("of somebody")
        file = self.path("hostile.pt")
        arguments = ("evaluate", file, "--scene", "bench", "--trials", 2, "--policy-timeout", 5,
                     "--policy-hz", 20)
        for module, says in ((Crashes(), "signal 8"), (TakesAll(), "memory"),
                             (Hangs(), "did not answer within")):
            torch.jit.script(module).save(file)
            self.refused(3, *arguments, says=["hostile.pt: the policy", says])
        for module in (Writes, Maps):
            for target in (victim, self.path("new")):
                torch.jit.script(module(target)).save(file)
                self.assertIn(ferrule(*arguments).returncode, (0, 3))
        if ctypes.CDLL(None).syscall(444, None, 0, 1) > 0:  # the kernel has Landlock
            self.assertEqual(open(victim).read(), "of somebody")
            self.assertFalse(os.path.exists(self.path("new")))
        with open(self.path("huge.pt"), "wb") as out:
            out.truncate(1 << 40)
        self.refused(3, "evaluate", self.path("huge.pt"), says=["huge.pt: is larger than"])

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
        run = ferrule("compare", folder, "--learners", "linear", "--policy", "exit 3", "--trials", 2,
                      "--json")
        self.assertEqual(run.returncode, 2)
        self.assertIn("exit 3: failed in each of 2 trials: the policy ended",
                      run.stderr.splitlines()[-1])
        rows = {row["controller"]: row for row in json.loads(run.stdout)["rows"]}
        self.assertEqual(rows["exit 3"]["outcomes"]["invalid_output"], 2)
        self.refused(2, "compare", folder, tuned, tuned, says=("twice",))
        self.refused(3, "compare", folder, self.path("nowhere.json"), says=("nowhere.json",))


if __name__ == "__main__":
    main()
