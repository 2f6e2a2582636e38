import json
import os

from case import Case, main


class Demo(Case):
    """Slow; only in the release build."""

    def test_the_main_job_and_its_steps(self):
        out = self.path("demo")
        run = self.done("demo", "--out", out, "--seed", 3, "--json")
        result = json.loads(run.stdout)
        self.assertGreaterEqual(result["success_rate"], 0.95)
        self.assertLessEqual(result["baseline"]["success_rate"], 0.60)
        self.assertIn(out + "/report.html", run.stderr)
        html = open(out + "/report.html").read()
        for text in ("95 % interval", "yield_y", "force_limit", "McNemar"):
            self.assertIn(text, html)
        self.styled_by_its_own(html)
        self.assertNotRegex(html, r"(src|href)=\"(?!data:)")
        self.assertEqual(html.count("<figure>"), 5)
        self.assertEqual([name.split()[-2] for name in self.forces_in_report(out + "/report.html")],
                         ["demonstration", "20", "20"])
        # The steps that the report names give the same numbers.
        again, controller = self.path("again"), self.path("controller.json")
        for skill, more in ((0.5, []), (0.9, ["--append"])):
            self.done("record", "--scene", "demo", "--skill", skill, "--episodes", 10, "--seed", 3,
                      "--out", again, *more)
        self.done("fit", again, "--method", "ceres", "--seed", 3, "--out", controller)
        gains = [json.load(open(f))["gains"] for f in (controller, out + "/controller.json")]
        self.assertEqual(*gains)
        # It runs again over its own folder, and not over a stranger's.
        other = self.path("other")
        os.mkdir(other)
        open(other + "/mine", "w").close()
        self.refused(2, "demo", "--out", other, says=["was not made by a demo"])


if __name__ == "__main__":
    main()
