import csv
import glob
import io
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import time
import xml.etree.ElementTree

import h5py
import numpy

from case import PROGRAM, QUICK, SOURCE, Case, ferrule, main

GIGABYTE = 1 << 30


class Damage(Case):
    """Files of strangers, and runs that are killed or cannot speak."""

    def episode(self):
        return self.record(self.path("out"), episodes=1)[0]

    # A copy of an episode with something changed by h5py.
    def changed(self, file, change):
        copy = self.path("changed.h5")
        shutil.copy(file, copy)
        with h5py.File(copy, "r+") as f:
            change(f)
        return copy

    # What the program does with a file: one line and an exit code, in time and memory.
    def survives(self, *arguments, codes=(0, 1, 2, 3)):
        begin = time.monotonic()
        run = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, timeout=60)
        self.assertIn(run.returncode, codes, (arguments, run.stderr))
        self.assertLessEqual(run.stderr.count(b"\n"), 1, run.stderr)
        self.assertLess(time.monotonic() - begin, 30, arguments)
        self.assertLess(1024 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss, GIGABYTE)
        return run

    def test_attributes_that_are_arrays_or_of_another_type_are_refused(self):
        file = self.episode()
        for key in ("period_s", "seed", "trial", "outcome", "scene", "format_version", "format",
                    "operator"):
            for value in (numpy.zeros(5000), numpy.zeros((3, 3), "i8"), ["x" * 1000] * 3,
                          numpy.zeros(2, [("a", "f8"), ("b", "S9")]), h5py.Empty("f8"), "x" * 60000,
                          numpy.inf, -1, 0.0, numpy.bytes_(b"\x00\xff")):
                bad = self.changed(file, lambda f: f.attrs.__setitem__(key, value))
                folder = self.path("folder")
                shutil.rmtree(folder, ignore_errors=True)
                os.mkdir(folder)
                shutil.copy(bad, folder)
                for command in (("replay", bad), ("score", folder),
                                ("fit", folder, "--out", self.path("c.json"))):
                    if key != "operator":
                        codes = (0, 2, 3) if key in ("seed", "trial") else (3,)
                        self.survives(*command, codes=codes if command[0] == "replay" else (0, 2, 3))
                    else:
                        self.survives(*command)
        bad = self.changed(file, lambda f: f.attrs.__setitem__("alpha_x", numpy.zeros(5000)))
        self.survives("replay", bad, "--verify", codes=(1, 3))

    def test_claims_beyond_the_file_are_not_believed(self):
        file = self.episode()

        def larger(name, rows, chunk=None):
            def change(f):
                old = f[name]
                shape, kind = (rows,) + old.shape[1:], old.dtype
                del f[name]
                f.create_dataset(name, shape, kind, chunks=chunk or (1024,) + shape[1:],
                                 compression="gzip")
            return change

        demo = "data/demo_0/"
        for change in (larger(demo + "rows/time", 90_000_000), larger(demo + "states", 90_000_000),
                       larger(demo + "rows/time", 1 << 40),
                       larger(demo + "rows/command", 100_000_000, (50_000_000, 5))):
            self.survives("replay", self.changed(file, change), codes=(3,))

        def everywhere(f):
            for name in ("time", "hand_pose", "hand_velocity", "command", "holder_wrench", "forces",
                         "status"):
                larger(demo + "rows/" + name, 20_000_000)(f)
            larger(demo + "states", 20_000_000)(f)
        self.survives("replay", self.changed(file, everywhere), codes=(3,))

    def test_numbers_of_other_files_and_links_are_not_followed(self):
        file = self.episode()

        def outside(f):
            del f["data/demo_0/rows/time"]
            f["data/demo_0/rows/time"] = h5py.ExternalLink(file, "data/demo_0/rows/time")

        def round_and_round(f):
            f["data/demo_0/rows/again"] = f["data"]
            f["data/soft"] = h5py.SoftLink("/data/soft")
        self.survives("replay", self.changed(file, outside), codes=(3,))
        self.survives("replay", self.changed(file, round_and_round), "--verify")

    def test_rows_that_are_no_numbers(self):
        file = self.episode()

        def no_numbers(f):
            f["data/demo_0/rows/forces"][5:] = numpy.nan
        bad = self.changed(file, no_numbers)
        self.refused(3, "replay", bad, "--plot", self.path("x.svg"), says=["row 5", "finite"])
        for value in (numpy.inf, 0.0, 1e-300, 1e9):
            bad = self.changed(file, lambda f: f.attrs.__setitem__("period_s", value))
            self.refused(3, "replay", bad, says=["period_s"])

    def test_verify_covers_every_object(self):
        file = self.episode()
        demo = "data/demo_0/"

        def attribute(place, key, value):
            return lambda f: f[place].attrs.__setitem__(key, value)
        changes = [attribute("/", "operator", numpy.bytes_(b"somebody else")),
                   attribute("/", "build", numpy.bytes_(b"another")),
                   attribute("/", "ferrule_version", numpy.bytes_(b"9.9")),
                   attribute("/", "rating", 5), attribute("/", "loop", numpy.bytes_(b"{}")),
                   attribute("/", "surprise", 1.0), attribute(demo, "surprise", 1.0),
                   attribute(demo + "states", "unit", numpy.bytes_(b"inch")),
                   attribute(demo + "rows/forces", "columns", numpy.bytes_(b"none")),
                   attribute(demo + "actions", "scale_m_s", 3.0),
                   attribute("data", "total", 7),
                   lambda f: f.create_dataset("data/demo_0/extra", data=[1.0]),
                   lambda f: f.create_group("data/demo_1"),
                   lambda f: f[demo + "states"].attrs.__delitem__("unit")]

        def last_command(f):
            f[demo + "rows/command"][-1] *= 0.5
            f[demo + "actions"][-1] *= 0.5
        for change in changes + [last_command]:
            run = ferrule("replay", self.changed(file, change), "--verify")
            self.assertEqual(run.returncode, 1, run.stdout + run.stderr)
            self.assertIn("recorded by ferrule", run.stdout)

    def test_verify_says_where_the_environment_differs(self):
        def change(f):
            environment = json.loads(f["data"].attrs["env_args"])
            environment["env_kwargs"]["scene"]["fibre"]["diameter_um"] = 124
            f["data"].attrs["env_args"] = numpy.bytes_(json.dumps(environment).encode())
        run = ferrule("replay", self.changed(self.episode(), change), "--verify")
        self.assertEqual(run.returncode, 1)
        self.assertIn("/env_kwargs/scene/fibre/diameter_um is 124, expected 125", run.stdout)

    def test_verify_within_a_tolerance_tells_the_largest_difference(self):
        file = self.episode()

        def change(f):
            states = f["data/demo_0/states"]
            states[300, 0] *= 1 + 1e-9
            states[400, 1] += 1e-12 * abs(states[:, :3]).max()
        bad = self.changed(file, change)
        self.assertEqual(ferrule("replay", bad, "--verify").returncode, 1)
        found = json.loads(self.done("replay", bad, "--verify", "--tolerance", 1e-6, "--json").stdout)
        self.assertFalse(found["identical"])
        self.assertTrue(found["within_tolerance"])
        self.assertEqual(found["largest_difference"]["row"], 300)
        self.assertEqual(ferrule("replay", bad, "--verify", "--tolerance", 1e-12).returncode, 1)
        self.assertIn("recorded by", self.done("replay", bad, "--verify", "--tolerance", 1e-6).stdout)

    def test_a_recording_without_a_hash_says_what_is_not_covered(self):
        bad = self.changed(self.episode(), lambda f: f.attrs.__delitem__("inputs_sha1"))
        self.assertIn("not covered", self.done("replay", bad, "--verify").stdout)

    def test_the_same_recording_is_the_same_file(self):
        files = [self.record(self.path(name), "--seed", 5, episodes=1)[0] for name in "ab"]
        one, two = (open(file, "rb").read() for file in files)
        self.assertEqual(one, two)

    def test_mutants_of_every_kind_of_file(self):
        file = self.episode()
        folder = os.path.dirname(file)
        self.record(folder, "--append", episodes=5)
        self.done("fit", folder, "--out", self.path("law.json"))
        kinds = [(file, lambda f: ("replay", f, "--verify")), (file, lambda f: ("replay", f)),
                 (SOURCE + "/data/scenes/demo.json", lambda f: ("forces", "--scene", f)),
                 (SOURCE + "/data/devices/pen.json",
                  lambda f: ("record", "--device", "fake:pid", "--profile", f, "--scene", "paper",
                             "--set", "success.depth_um=-1", "--out", self.path("never"))),
                 (self.path("law.json"), lambda f: ("export", f, "--header", self.path("x.h")))]
        draw = random.Random(3)
        for source, command in kinds:
            whole = open(source, "rb").read()
            for _ in range(40):
                bad = bytearray(whole)
                for _ in range(draw.choice((1, 1, 3, 30))):
                    at = draw.randrange(min(len(bad), draw.choice((3000, len(bad)))))
                    bad[at] = draw.choice((0, 255, draw.randrange(256), bad[at] ^ 1 << draw.randrange(8)))
                if draw.randrange(8) == 0:
                    bad = bad[:draw.randrange(len(bad))]
                mutant = self.path("mutant" + os.path.splitext(source)[1])
                with open(mutant, "wb") as out:
                    out.write(bad)
                self.survives(*command(mutant))

    def test_what_is_no_file_is_refused_at_once(self):
        pipe = self.path("pipe.json")
        os.mkfifo(pipe)
        self.refused(3, "forces", "--scene", pipe, says=["pipe.json"])
        self.refused(3, "replay", pipe, says=["pipe.json"])
        self.refused(3, "export", pipe, "--header", self.path("x.h"), says=["pipe.json"])
        long = self.path("x" * 300)
        self.refused(3, "replay", long + ".h5", says=["no such file"])
        self.refused(3, "forces", "--scene", long + ".json")
        run = ferrule("forces", "--scene", "\x1b[31m\n" + "x" * 100_000)
        self.assertEqual(run.returncode, 3)
        self.assertLess(len(run.stderr), 2000)
        self.assertNotIn("\x1b", run.stderr)

    def test_what_cannot_be_written_is_refused_in_one_line(self):
        folder = os.path.dirname(self.episode())
        self.record(folder, "--append", episodes=5)
        self.done("fit", folder, "--out", self.path("law.json"))
        pipe, long = self.path("pipe"), self.path("x" * 300)
        os.mkfifo(pipe)
        for place in (pipe, long, self.path("none") + "/x"):
            for arguments in (["fit", folder, "--out", place + ("" if place == pipe else ".json")],
                              ["export", self.path("law.json"), "--header", place],
                              ["plan", "--tolerance", 0.1, "--out", place],
                              ["forces", "--gap-nm", "1:9:3", "--plot", place]):
                run = ferrule(*arguments)
                self.assertEqual(run.returncode, 3, (arguments, run.stderr))
                self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
                self.assertNotIn("made by", run.stdout)
        run = ferrule("record", "--episodes", 1, "--out", long)
        self.assertEqual((run.returncode, run.stderr.count("\n")), (3, 1))
        self.assertEqual(sorted(os.listdir(self.folder)), ["law.json", "out", "pipe"])

    # The next run that writes the same file takes away what a killed one left of it.
    # Names in files of others are shown on a terminal.
    def test_names_with_control_characters_are_refused_or_escaped(self):
        scene = json.load(open(SOURCE + "/data/scenes/paper.json"))
        profile = json.load(open(SOURCE + "/data/devices/pen.json"))
        for name in ("red \x1b[31m", "two\nlines", "x" * 101, "\x7f"):
            json.dump({**scene, "name": name}, open(self.path("s.json"), "w"))
            json.dump({**profile, "name": name}, open(self.path("p.json"), "w"))
            self.refused(2, "forces", "--scene", self.path("s.json"), says=["s.json: line 1: name = "])
            self.refused(2, "doctor", "--device", self.path("p.json"), says=["p.json: line 1: name = "])
        json.dump({**scene, "name": "Fa\u00ebr " + "\u00e9" * 95}, open(self.path("s.json"), "w"))
        self.done("forces", "--scene", self.path("s.json"))

        def renamed(f):
            f.attrs["operator"] = numpy.bytes_(b"red \x1b[31m")
        folder = os.path.dirname(self.changed(self.episode(), renamed))
        os.mkdir(self.path("of"))
        shutil.move(folder + "/changed.h5", self.path("of/episode_0001.h5"))
        text = self.done("score", self.path("of")).stdout
        self.assertNotIn("\x1b", text)
        self.assertIn("red \\x1b[31m", text)

    def test_names_of_files_are_escaped_wherever_they_are_shown(self):
        odd = self.path("red \x1b[31m\nline \u009b2J")
        os.mkdir(odd)
        out, law = os.path.join(odd, "out"), os.path.join(odd, "law.json")
        scene = os.path.join(odd, "scene.json")
        shutil.copy(SOURCE + "/data/scenes/paper.json", scene)
        short = ("--scene", scene, *QUICK)
        journal = os.path.join(out, "episode_0009.part")
        for arguments in (
                ("record", *short, "--episodes", 6, "--out", out),
                ("record", *short, "--episodes", 1, "--append", "--out", out),
                ("replay", out), ("replay", out + "/episode_0001.h5", "--verify"),
                ("score", out), ("forces", out + "/episode_0001.h5"),
                ("forces", out + "/episode_0001.h5", "--against", out + "/episode_0002.h5"),
                ("fit", out, "--out", law, "--plot", law + ".svg"),
                ("export", law, "--header", law + ".h"),
                ("evaluate", law, "--trials", 2, "--baseline", "constant-velocity",
                 "--report", law + ".html"),
                ("record", "--operator", law, "--episodes", 1, "--append", "--out", out),
                ("compare", out, law, "--learners", "linear", "--trials", 2, "--plot", odd + "/plots"),
                ("identify", out, "--parameters", "laws.friction.burgers_nm"),
                ("limits", "--scene", scene), ("scene", "--scene", scene),
                ("plan", "--scene", scene, "--tolerance", 0.1, "--out", odd + "/planned.json"),
                ("demo", *short, "--out", odd + "/demo"), ("recover", out)):
            if arguments[0] == "recover":
                open(journal, "w").close()
            run = ferrule(*arguments)
            text = run.stdout + run.stderr
            self.assertIn(run.returncode, (0, 1), (arguments, text))
            self.assertNotIn("\x1b", text, arguments)
            self.assertNotIn("\u009b", text, arguments)
            self.assertNotIn("\nline ", text, arguments)
            self.assertIn("red \\x1b[31m\\x0aline \\xc2\\x9b2J", text, arguments)

    # Whatever a text says to a reader of SVG, it is drawn as it is.
    def test_any_text_can_be_drawn(self):
        scene = json.load(open(SOURCE + "/data/scenes/paper.json"))
        folder, plot, made = self.path("folder"), self.path("plot.svg"), self.path("made")
        file = self.record(folder, episodes=2)[0]
        for text in ("two'' and three''' and it's", "'", "''", '"quoted" \\ \\n \\047 7', "`touch made`", "EOD",
                     "$x @y %d 50%% #z", "{/Symbol a}_b^c ~a{.8-}", "<script>alert(1)</script> & &lt;",
                     "1'2''3 \u00b5m \u65e5"):
            json.dump({**scene, "name": text}, open(self.path("s.json"), "w"))
            self.done("forces", "--scene", self.path("s.json"), "--gap-nm", "1:9:3", "--plot", plot, cwd=self.folder)
            drawn = "".join(xml.etree.ElementTree.parse(plot).getroot().itertext())
            self.assertIn(text, drawn)

            def named(f):
                f.attrs["operator"] = numpy.bytes_(text.encode())
            shutil.move(self.changed(file, named), file)
            self.done("score", folder, "--plot", plot, cwd=self.folder)
            drawn = "".join(xml.etree.ElementTree.parse(plot).getroot().itertext())
            self.assertIn(text + ", scene", drawn)
            self.assertFalse(os.path.exists(made))

    # A spreadsheet computes what begins with one of these.
    def test_texts_of_a_csv_are_no_formulas(self):
        folder = self.path("folder")
        file = self.record(folder, episodes=1)[0]
        for sign in ("=", "+", "-", "@", " =", "\uff1d", "\uff20"):
            name = sign + "cmd|' /C calc'!A0"

            def renamed(f):
                f.attrs["operator"] = numpy.bytes_(name.encode())
            shutil.move(self.changed(file, renamed), file)
            table = self.done("score", folder, "--csv").stdout
            [row] = csv.DictReader(io.StringIO(table))
            self.assertEqual(row["operator"], "'" + name)
        # Where semicolons or tabs part the fields none begins a formula either; and terminals obey nothing.
        for name, shown in (('a;=1+1;"b', """a;'=1+1;"b"""), ('a"; "@x;', """a";' "@x;"""),
                            ("a\t=1+1", "a\\x09=1+1"), ("\x1b]0;x\x07\x9b2J\r\n=1+1", None)):
            def named(f):
                f.attrs["operator"] = numpy.bytes_(name.encode())
            shutil.move(self.changed(file, named), file)
            for how in ("--csv", "--json"):
                table = self.done("score", folder, how).stdout
                self.assertNotRegex(table, "[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f]")
            table = self.done("score", folder, "--csv").stdout
            [row] = csv.DictReader(io.StringIO(table))
            self.assertNotRegex(row["operator"], "[\x00-\x1f\x7f-\x9f]")
            if shown:
                self.assertEqual(row["operator"], shown)
            for separator in ";\t":
                for line in csv.reader(io.StringIO(table), delimiter=separator):
                    for field in line:
                        self.assertFalse(field.lstrip().startswith(("=", "+", "@")), (name, field))
        scene = json.load(open(SOURCE + "/data/scenes/paper.json"))
        json.dump({**scene, "name": "=1+1"}, open(self.path("s.json"), "w"))
        table = self.done("forces", "--scene", self.path("s.json"), "--gap-nm", "1:9:3", "--csv").stdout
        for row in csv.DictReader(io.StringIO(table)):
            self.assertEqual(row["scene"], "'=1+1")
            self.assertLess(float(row["van_der_waals_uN"]), 0)

    def test_half_written_files_are_removed_by_the_next_run(self):
        folder = os.path.dirname(self.episode())
        self.record(folder, "--append", episodes=5)
        for name in ("law.json.Ab3dEf.tmp", "other.json.Ab3dEf.tmp"):
            with open(self.path(name), "w") as out:
                out.write("half")
        self.done("fit", folder, "--out", self.path("law.json"))
        self.assertEqual(sorted(os.listdir(self.folder)),
                         ["law.json", "other.json.Ab3dEf.tmp", "out"])

    def test_half_written_files_of_killed_runs_are_removed(self):
        folder = self.path("out")
        self.record(folder, episodes=1)
        for name in ("episode_0002.h5.Ab3dEf.tmp", "kept.tmp", "kept.txt.Ab3dEf.tmp"):
            with open(os.path.join(folder, name), "w") as out:
                out.write("half")
        self.done("recover", folder)
        self.assertEqual(sorted(os.listdir(folder)),
                         ["episode_0001.h5", "kept.tmp", "kept.txt.Ab3dEf.tmp"])

    def test_stderr_that_cannot_be_written_changes_nothing(self):
        file = self.episode()

        def closed():
            os.close(2)
        run = subprocess.run([PROGRAM, "replay", file], preexec_fn=closed, stdout=subprocess.PIPE)
        self.assertEqual(run.returncode, 0)
        run = subprocess.run([PROGRAM, "replay", "none.h5"], preexec_fn=closed,
                             stdout=subprocess.PIPE)
        self.assertEqual(run.returncode, 3)
        for command, code in ((("replay", "none.h5"), 3), (("forces", "--scene", "x"), 3),
                              (("record", "--device", "fake:pid", *QUICK, "--scene", "paper",
                                "--episodes", "1", "--out", self.path("felt")), None)):
            end, other = os.pipe()
            os.close(end)
            run = subprocess.run([PROGRAM, *command], stderr=other, stdout=subprocess.PIPE)
            os.close(other)
            self.assertGreaterEqual(run.returncode, 0)
            if code is not None:
                self.assertEqual(run.returncode, code)

    def test_what_ended_a_recording_is_called_by_its_name(self):
        process = subprocess.Popen([PROGRAM, "record", "--scene", "paper", "--episodes", "1000",
                                    "--out", self.path("out")], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        process.stdout.readline()
        process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assertIn("SIGTERM", errors)
        self.assertNotIn("Ctrl-C", errors)

    def test_more_threads_than_cores_are_said(self):
        run = self.done("evaluate", "--scene", "paper", *QUICK, "--baseline", "constant-velocity",
                        "--trials", 4, "--threads", 4096)
        self.assertIn("4096", run.stderr)


if __name__ == "__main__":
    main()
