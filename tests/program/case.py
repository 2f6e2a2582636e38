"""Whole runs of the program, as a user and a reader of its files sees them.

usage: GROUP.py PROGRAM SOURCE_FOLDER BUILD_FOLDER [CLASS.TEST ...]
"""

import base64
import glob
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import jsonschema

PROGRAM, SOURCE, BUILD = map(os.path.abspath, sys.argv[1:4])
QUICK = ["--set", "start.distance_um=10", "--set", "success.depth_um=8",
         "--set", "limits.speed_um_s=20", "--set", "start.lateral_sd_um=4"]


def sanitized():
    """Whether the program is built with sanitizers, which take memory of their own."""
    with open(BUILD + "/CMakeCache.txt") as cache:
        return "FERRULE_SANITIZE:BOOL=ON" in cache.read()


def ferrule(*arguments, timeout=600, **options):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          timeout=timeout, **options)


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="ferrule-test-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def path(self, name):
        return os.path.join(self.folder, name)

    def done(self, *arguments, **options):
        run = ferrule(*arguments, **options)
        self.assertEqual(run.returncode, 0, run.stderr)
        return run

    def refused(self, code, *arguments, says=(), **options):
        run = ferrule(*arguments, **options)
        self.assertEqual(run.returncode, code, run.stderr + run.stdout)
        self.assertEqual(run.stdout, "")
        self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
        for text in says:
            self.assertIn(text, run.stderr)

    def styled_by_its_own(self, html):
        """The policy of a report allows its own style, by its hash, and no style of what is in it."""
        policy, style = re.search("<meta http-equiv=\"Content-Security-Policy\" content=\"(default-src 'none';.*?)\">"
                                  ".*?<style>(.*?)</style>", html, re.DOTALL).groups()
        digest = base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
        self.assertIn(f"style-src 'sha256-{digest}'", policy)  # the new hash, where the style was changed
        self.assertNotIn("unsafe-inline", policy)
        own = re.sub('srcdoc=".*?"', "", html, flags=re.DOTALL)
        self.assertEqual(own.count("<style"), 1)
        self.assertNotRegex(own, r"<[^>]*\sstyle=")

    def forces_in_report(self, file):
        """The table of which force acted when: name of the runs -> force -> column -> text."""
        with open(file) as report:
            section = report.read().split("<h2>Which force acted when</h2>")[1].split("</table>")[0]
        names, *rows = re.findall(r"<tr.*?>(.*?)</tr>", section)
        names = re.findall("<th>(.*?)</th>", names)
        found = {}
        for row in rows:
            name = re.match(r"<th colspan=\d+>(.*?)<br>", row)
            if name:
                runs = found[name[1]] = {}
            else:
                force, *cells = re.findall("<td.*?>(.*?)</td>", row)
                runs[force] = dict(zip(names[1:], cells, strict=True))
        return found

    def schema_validator(self, name):
        with open(SOURCE + "/data/" + name) as file:
            schema = json.load(file)
        jsonschema.Draft202012Validator.check_schema(schema)
        files = jsonschema.RefResolver("file://" + os.path.abspath(SOURCE + "/data/" + name), schema)
        return jsonschema.Draft202012Validator(schema, resolver=files)

    def record(self, out, *more, episodes=3):
        self.done("record", "--scene", "paper", *QUICK, "--episodes", episodes, "--out", out, *more)
        return sorted(glob.glob(out + "/*.h5"))


def main():
    unittest.main(argv=[sys.argv[0], "-v"] + sys.argv[4:], warnings="ignore")
