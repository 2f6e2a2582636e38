"""Whole runs of the program, as a user and a reader of its files sees them.

usage: program_test.py GROUP PROGRAM SOURCE_FOLDER BUILD_FOLDER
"""

import copy
import glob
import hashlib
import json
import math
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import h5py
import jsonschema
import numpy

PROGRAM, SOURCE, BUILD = "", "", ""
QUICK = ["--set", "start.distance_um=10", "--set", "success.depth_um=8",
         "--set", "limits.speed_um_s=20", "--set", "start.lateral_sd_um=4"]


def ferrule(*arguments, **options):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          timeout=600, **options)


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

    def record(self, out, *more, episodes=3):
        self.done("record", "--scene", "paper", *QUICK, "--episodes", episodes, "--out", out, *more)
        return sorted(glob.glob(out + "/*.h5"))


class Forces(Case):
    def test_curves_are_the_printed_formulas(self):
        hamaker, volts, gamma, angle, film = 1.3e-19, 0.37, 0.031, math.radians(41), 55e-9
        run = self.done("forces", "--gap-nm", "1:500:50:log", "--length-um", 73, "--json",
                        "--set", f"laws.van_der_waals.hamaker_J={hamaker}",
                        "--set", f"laws.electrostatic.voltage_V={volts}",
                        "--set", f"laws.capillary.surface_tension_N_m={gamma}",
                        "--set", f"laws.capillary.contact_angle_deg={math.degrees(angle)}",
                        "--set", f"laws.capillary.film_nm={film * 1e9}")
        document = json.loads(run.stdout)
        self.assertEqual(document["scene"], "paper")
        rows = document["rows"]
        self.assertEqual(len(rows), 50)
        self.assertEqual(rows[-1]["gap_nm"], 500)
        area = 62.5e-6 * math.pi / 2 * 73e-6
        for row in rows:
            h = row["gap_nm"] * 1e-9
            vdw = -hamaker * area / (24 * math.pi * h**3) if h <= 100e-9 else 0
            self.same(row["van_der_waals_uN"], vdw * 1e6)
            self.same(row["electrostatic_uN"], -8.85e-12 * volts**2 * area / (2 * h**2) * 1e6)
            r1 = h / (2 * math.cos(angle))
            cap = -2 * gamma * 73e-6 * (1 - (h - 2 * film) / (2 * r1)) * math.cos(angle)
            self.same(row["capillary_uN"], cap * 1e6)
            self.same(row["gravity_uN"], -2330 * math.pi * 62.5e-6**2 * 0.05 * 1e6)
            self.assertEqual(row["adhesion_uN"], 0)
            self.assertEqual(row["friction_uN"], 0)
            self.assertFalse(row["in_contact"])

    def same(self, a, b):
        self.assertLessEqual(abs(a - b), 1e-11 * abs(b), (a, b))

    def test_adhesion_and_friction_of_table_i_against_depth(self):
        rows = json.loads(self.done("forces", "--depth-nm", "0:10:11", "--json").stdout)["rows"]
        self.assertEqual([row["depth_nm"] for row in rows], list(range(11)))
        for row, adhesion, friction in ((rows[0], -5.574418828, 0.1296897463),
                                        (rows[10], -7.830277437, 0.1728765087)):
            self.assertAlmostEqual(row["adhesion_uN"] / adhesion, 1, delta=2e-9)
            self.assertAlmostEqual(row["friction_uN"] / friction, 1, delta=2e-9)

    def test_forces_grow_in_a_straight_line_with_the_inserted_length(self):
        rows = json.loads(self.done("forces", "--length-um", "0:200:21", "--json").stdout)["rows"]
        for row in rows:
            self.assertAlmostEqual(row["capillary_uN"], rows[10]["capillary_uN"] *
                                   row["length_um"] / 100, delta=1e-9)

    def test_a_tilted_fibre_feels_the_mean_over_its_gaps(self):
        scene = ["--json", "--set", "laws.van_der_waals.form=corrected",
                 "--set", "laws.electrostatic.form=corrected",
                 "--set", "laws.capillary.form=corrected"]
        tilted = json.loads(self.done("forces", "--gap-nm", 10, "--length-um", 100,
                                      "--tilt-mrad", 1, *scene).stdout)["rows"][0]
        gaps = 4000
        rows = json.loads(self.done("forces", "--length-um", 100, "--gap-nm",
                                    f"{10 + 50 / gaps}:{110 - 50 / gaps}:{gaps}",
                                    *scene).stdout)["rows"]
        for name in ("van_der_waals_uN", "electrostatic_uN", "capillary_uN"):
            mean = sum(row[name] for row in rows) / gaps
            self.assertLess(mean, 0)
            self.assertLessEqual(abs(tilted[name] / mean - 1), 1e-3, name)

    def test_plot_is_a_drawing(self):
        file = self.path("plot.svg")
        for sweep in (["--gap-nm", "1:500:50:log"], ["--length-um", "0:200:21"],
                      ["--depth-nm", "0:10:11"]):
            self.done("forces", *sweep, "--plot", file)
            text = open(file).read()
            self.assertIn("</svg>", text)
            self.assertGreater(text.count("<path"), 5)

    def test_corrected_forms_are_those_of_the_literature(self):
        lengths, roughness = 100e-6, 0
        run = self.done("forces", "--form", "corrected", "--set",
                        "laws.capillary.volume_per_length_m2=3e-12", "--set",
                        "laws.capillary.rupture_nm=400", "--gap-nm", "1:450:31:log", "--json")
        r, big_r = 62.5e-6, 63e-6
        c, e0 = big_r - r, 8.8541878128e-12
        for row in json.loads(run.stdout)["rows"]:
            h = row["gap_nm"] * 1e-9
            e = c - h
            vdw = -3.67e-19 * r * c * e / (2 * ((c - e) * (c + e)) ** 2.5) * lengths
            self.assertAlmostEqual(row["van_der_waals_uN"] / (vdw * 1e6), 1, delta=1e-8)
            t = (c - e) * (c + e) / (2 * r * big_r)
            root = math.sqrt(t * (2 + t))
            angle = math.log1p(t + root)
            slope = 2 * math.pi * e0 / angle**2 / root * e / (r * big_r)
            self.assertAlmostEqual(row["electrostatic_uN"] / (-0.005 * slope * lengths * 1e6), 1,
                                   delta=1e-7)
            radius = r * big_r / c
            low, high = 0, 1e-3
            for _ in range(200):  # bisection for the half width
                x = (low + high) / 2
                low, high = (x, high) if 2 * (h * x + x**3 / (6 * radius)) < 3e-12 else (low, x)
            cap = -4 * 0.072 * 0.5 * x / (h + x * x / (2 * radius)) * lengths * 1e6
            self.assertAlmostEqual(row["capillary_uN"], cap if h < 400e-9 else 0, delta=1e-9 * abs(cap))
            self.assertAlmostEqual(row["gravity_uN"], -14.020, delta=1e-3)

    def test_forms(self):
        self.refused(2, "forces", "--form", "corrected", "--set", "laws.capillary.rupture_nm=100",
                     says=["laws.capillary.rupture_nm = 100", "film_nm"])
        self.refused(2, "forces", "--form", "printed", "--set",
                     'laws.drag={"form": "corrected", "viscosity_Pa_s": 1}', says=["drag"])

    def test_names_cannot_reach_the_plotting_program(self):
        scene = json.load(open(SOURCE + "/data/scenes/paper.json"))
        scene["name"] = f"x\nsystem \"touch {self.path('reached')}\"\n#'"
        json.dump(scene, open(self.path("named.json"), "w"))
        self.done("forces", "--scene", self.path("named.json"), "--gap-nm", "1:9:9", "--plot",
                  self.path("p.svg"))
        self.assertFalse(os.path.exists(self.path("reached")))

    def test_a_plot_follows_a_link_and_leaves_a_device_a_device(self):
        target, link = self.path("target.svg"), self.path("link.svg")
        open(target, "w").close()
        os.symlink(target, link)
        for file in (link, "/dev/null"):
            self.done("forces", "--gap-nm", "1:9:9", "--plot", file)
        self.assertTrue(os.path.islink(link))
        self.assertIn("</svg>", open(target).read())
        self.assertFalse(os.path.isfile("/dev/null"))

    def test_bad_ranges(self):
        for text in ("", "a", "1:2", "1:2:0", "1:2:3:lin", "0:5:3:log", "-1", "1:2:2.5", "nan"):
            self.refused(2, "forces", "--gap-nm=" + text, says=["--gap-nm"])


class Scenes(Case):
    def test_json_nested_without_end_is_refused(self):
        file = self.path("deep.json")
        with open(file, "w") as f:
            f.write("[" * 100000 + "]" * 100000)
        self.refused(2, "plan", "--scene", file, says=("nested deeper",))

    def test_an_accuracy_that_is_not_reached_is_said(self):
        run = self.done("record", "--scene", "paper", "--episodes", 1, "--out", self.path("slow"),
                        "--set", "accuracy=1e-6", "--set", "limits.time_s=1")
        self.assertIn("accuracy = 1e-06 is not reached", run.stderr)

    def setUp(self):
        super().setUp()
        self.schema = json.load(open(SOURCE + "/data/scenes/scene.schema.json"))
        jsonschema.Draft202012Validator.check_schema(self.schema)
        self.validator = jsonschema.Draft202012Validator(self.schema)
        self.paper = json.load(open(SOURCE + "/data/scenes/paper.json"))

    def program_takes(self, scene):
        file = self.path("scene.json")
        with open(file, "w") as out:
            json.dump(scene, out)
        run = ferrule("forces", "--scene", file, "--json")
        self.assertIn(run.returncode, (0, 2), run.stderr)
        if run.returncode == 2:
            self.assertTrue(run.stderr.startswith("ferrule: " + file + ": "), run.stderr)
            self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
        return run.returncode == 0

    def test_all_shipped_scenes_are_valid(self):
        for file in glob.glob(SOURCE + "/data/scenes/*.json"):
            if not file.endswith(".schema.json"):
                self.validator.validate(json.load(open(file)))
                self.assertTrue(self.program_takes(json.load(open(file))), file)

    def test_schema_and_program_agree_on_broken_scenes(self):
        draw = random.Random(4)
        paths = []

        def walk(node, path):
            if isinstance(node, dict):
                for key in node:
                    paths.append(path + [key])
                    walk(node[key], path + [key])

        walk(self.paper, [])
        values = [-1, 0, "text", None, [], {}, True, 1e-3, 0.3, 95, [0, 0], 1e300]
        refused = 0
        for _ in range(150):
            scene = copy.deepcopy(self.paper)
            path = draw.choice(paths)
            place = scene
            for key in path[:-1]:
                place = place[key]
            how = draw.randrange(4)
            if how == 0:
                del place[path[-1]]
            elif how == 1:
                place["surprise"] = draw.choice(values)
            else:
                place[path[-1]] = draw.choice(values)
            # What no schema can say: relations between keys.
            if path[-1] in ("diameter_um", "bore_diameter_um", "depth_um", "length_mm"):
                continue
            valid = self.validator.is_valid(scene)
            self.assertEqual(self.program_takes(scene), valid, (path, how, scene))
            refused += not valid
        self.assertGreater(refused, 50)

    def test_every_verb_takes_scene_and_set(self):
        for verb in ("forces", "record", "evaluate"):
            text = self.done(verb, "--help").stdout
            self.assertIn("--scene", text)
            self.assertIn("--set", text)

    def test_messages(self):
        self.refused(2, "forces", "--set", "ferrule.bore_diameter_um=124.9",
                     says=["paper.json", "ferrule.bore_diameter_um = 124.9", "wider than the fibre"])
        self.refused(2, "forces", "--set", "fibre.poisson=0.6", says=["fibre.poisson = 0.6"])
        self.refused(2, "forces", "--set", "scaling.tip_range_um=1e-320", says=["scaling"])
        self.refused(2, "forces", "--set", "holder.tpye=3", says=["holder.tpye = 3", "unknown key"])
        self.refused(3, "forces", "--scene", "nowhere", says=["nowhere", "paper"])
        self.refused(3, "forces", "--scene", "/no/where.json", says=["/no/where.json"])
        broken = self.path("broken.json")
        for text in ('{"name": "x",\n "fibre": NaN}', '{"name": "a", "name": "b"}', "", "[1, 2]", "\x00\xff", '{"name": 1e999}'):
            with open(broken, "w") as out:
                out.write(text)
            self.refused(2, "forces", "--scene", broken, says=[broken])


class Usage(Case):
    def test_wrong_usage_is_one_line_and_code_2(self):
        for arguments in ([], ["dance"], ["forces", "--gap"], ["record"], ["record", "--skill", "2",
                          "--out", "x"], ["evaluate"], ["fit", "x"], ["evaluate", "--trials", "0",
                          "--baseline", "constant-velocity"], ["record", "--episodes", "many",
                          "--out", "x"], ["evaluate", "--baseline", "hope"]):
            self.refused(2, *arguments)

    def test_help_and_version(self):
        text = self.done("--help").stdout
        for verb in ("demo", "forces", "record", "recover", "replay", "fit", "evaluate"):
            self.assertIn(verb, text)
            self.assertTrue(self.done(verb, "--help").stdout)
        self.assertRegex(self.done("--version").stdout, r"^\d+\.\d+\.\d+ ")

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


class Bench(Case):
    def test_contact_gives_the_published_values(self):
        rows = json.loads(self.done("contact", "--lambda", 4, "--radius", "0.3,1,2", "--json").stdout)
        rows = rows["rows"]
        self.assertEqual([row["A"] for row in rows], [0.3, 1, 2])
        for row, m, p, d in ((rows[1], 1.044223169, -1.476575195, -0.603569589),
                             (rows[2], 1.021379139, 1.252730387, 1.782581218)):
            self.assertAlmostEqual(row["m"], m, delta=1e-9)
            self.assertAlmostEqual(row["P"], p, delta=1e-9)
            self.assertAlmostEqual(row["D"], d, delta=1e-9)
        for lam in (0.01, 0.7, 0.93, 100):
            self.done("contact", "--lambda", lam, "--curve", "--json", "--plot", self.path("c.svg"))
            self.assertIn("</svg>", open(self.path("c.svg")).read())
        for bad in ("0", "101", "nan", "x"):
            self.refused(2, "contact", "--lambda", bad, "--curve", says=["--lambda"])
        self.refused(2, "contact", "--lambda", 4, "--radius", "1,-1", says=["--radius"])

    def test_a_plan_is_a_scene_and_accuracy_applies_it(self):
        plan = json.loads(self.done("plan", "--scene", "demo", "--tolerance", 0.02, "--json",
                                    "--out", self.path("planned.json")).stdout)
        self.assertEqual(set(plan), {"tolerance", "terms", "dynamics", "step_s", "error_bound"})
        self.assertEqual(plan["tolerance"], 0.02)
        self.assertLessEqual(plan["error_bound"], 0.02)
        for term in plan["terms"]:
            self.assertEqual(set(term), {"name", "kept", "fidelity", "max_force_uN",
                                         "relative_error", "cost_ns"})
        planned = json.load(open(self.path("planned.json")))
        self.assertEqual(planned["planned_accuracy"], 0.02)
        for term in plan["terms"]:
            if not term["kept"] and term["name"] != "inertia":
                self.assertIsNone(planned["laws"][term["name"]])
        # The same scene by its key.
        self.done("record", "--scene", "demo", "--set", "accuracy=0.02", "--operator", "simulated",
                  "--episodes", 1, "--seed", 4, "--out", self.path("a"))
        self.done("record", "--scene", self.path("planned.json"), "--operator", "simulated",
                  "--episodes", 1, "--seed", 4, "--out", self.path("b"))
        with h5py.File(self.path("a/episode_0001.h5")) as a, \
                h5py.File(self.path("b/episode_0001.h5")) as b:
            self.assertEqual(json.loads(a.attrs["scene"]), planned)
            self.assertTrue((a["data/demo_0/states"][:] == b["data/demo_0/states"][:]).all())
        self.done("replay", self.path("a/episode_0001.h5"), "--verify")
        self.refused(2, "plan", "--tolerance", 0.9, says=["--tolerance"])
        self.refused(2, "forces", "--set", "accuracy=2", says=["accuracy = 2"])

    def test_capture_takes_exactly_what_fits(self):
        rows = json.loads(self.done("bench", "capture", "--json").stdout)["rows"]
        self.assertGreater(len(rows), 600)
        for row in rows:
            self.assertEqual(row["inserted"], row["offset_clearances"] < 1, row)
        self.assertEqual({row["direction_deg"] for row in rows}, {45.0 * k for k in range(8)})
        self.assertEqual({row["step_s"] for row in rows}, {1e-4, 1e-3, 1e-2})


class Recording(Case):
    def test_an_episode_is_read_by_h5py_as_documented(self):
        files = self.record(self.path("out"))
        self.assertEqual(len(files), 3)
        with h5py.File(files[1]) as f:
            self.assertEqual(f.attrs["format"], b"ferrule episode")
            self.assertEqual(f.attrs["outcome"], b"inserted")
            self.assertEqual(json.loads(f.attrs["scene"])["name"], "paper")
            self.assertEqual(f.attrs["trial"], 2)
            self.assertAlmostEqual(f.attrs["alpha_x"], 250)
            demo = f["data/demo_0"]
            n = demo.attrs["num_samples"]
            self.assertEqual(f["data"].attrs["total"], n)
            arguments = json.loads(f["data"].attrs["env_args"])
            self.assertTrue({"env_name", "type", "env_type", "env_version", "env_kwargs"}
                            <= set(arguments))
            for name in ("actions", "states"):
                self.assertEqual(demo[name].shape[0], n)
                self.assertEqual(demo[name].compression, "gzip")
            self.assertEqual(demo["rewards"].shape, (n,))
            self.assertEqual(demo["dones"][-1], 1)
            self.assertEqual(demo["rewards"][-1], 1)
            self.assertLessEqual(abs(demo["actions"][:]).max(), 1)
            for key in demo["obs"]:
                now, later = demo["obs"][key][:], demo["next_obs"][key][:]
                self.assertTrue((now[1:] == later[:-1]).all())
            # Unscaled actions are the commands, and commands move the hand.
            scale = demo["actions"].attrs["scale_m_s"]
            command = demo["rows/command"][:]
            numpy.testing.assert_allclose(demo["actions"][:, 0] * scale, command[:, 0], rtol=1e-12)
            pose = demo["rows/hand_pose"][:]
            numpy.testing.assert_allclose(numpy.diff(pose, axis=0) / 1e-3, command[:-1], atol=1e-11)
            # The hand's world is the tip's, scaled: the hand in the state is the hand's pose.
            numpy.testing.assert_allclose(demo["states"][:, 5:8] * 250, pose[:, :3], rtol=1e-12)
            wrench = demo["rows/holder_wrench"][:, :3]
            numpy.testing.assert_allclose(demo["obs/wrench_N"][:, :3], wrench * 8.46e5, rtol=1e-5,
                                          atol=1e-6)
            # In equilibrium the holder carries the sum of all other forces.
            total = demo["rows/forces"][:].reshape(n, 9, 3).sum(axis=1)
            numpy.testing.assert_allclose(total, wrench, atol=5e-11)

            def units(name, item):
                if isinstance(item, h5py.Dataset):
                    self.assertIn("unit", item.attrs, name)
                    self.assertIn("columns", item.attrs, name)

            demo.visititems(units)

    def test_same_seed_same_rows_other_seed_other_rows(self):
        a = self.record(self.path("a"), "--seed", 5, episodes=1)[0]
        b = self.record(self.path("b"), "--seed", 5, episodes=1)[0]
        c = self.record(self.path("c"), "--seed", 6, episodes=1)[0]
        states = [h5py.File(f)["data/demo_0/states"][:] for f in (a, b, c)]
        self.assertTrue((states[0] == states[1]).all())
        self.assertFalse(states[0].shape == states[2].shape and (states[0] == states[2]).all())

    def test_a_folder_with_episodes_is_only_added_to_when_asked(self):
        out = self.path("out")
        self.record(out, episodes=1)
        self.refused(2, "record", "--out", out, says=["--append"])
        self.assertEqual(len(self.record(out, "--append", episodes=2)), 3)

    def test_kill_loses_no_finished_episode_and_recover_brings_back_the_running_one(self):
        for delay in (0.3, 0.8, 1.3):
            out = self.path(f"out{delay}")
            process = subprocess.Popen([PROGRAM, "record", "--scene", "paper", "--episodes", "1000",
                                        "--out", out], stdout=subprocess.PIPE, text=True)
            first = process.stdout.readline()
            self.assertIn("episode_0001.h5", first)
            time.sleep(delay)
            process.kill()
            told = [first] + process.stdout.read().splitlines()
            process.wait()
            process.stdout.close()
            whole = glob.glob(out + "/*.h5")
            self.assertGreaterEqual(len(whole), len([t for t in told if ".h5" in t]))
            parts = glob.glob(out + "/*.part")
            # Between two episodes there may be none; one that had no rows yet stays.
            result = json.loads(self.done("recover", out, "--json").stdout)["recovered"]
            self.assertEqual(len(result), len(parts))
            for each in result:
                if each["file"]:
                    with h5py.File(each["file"]) as f:
                        self.assertEqual(f["data/demo_0/states"].shape[0], each["rows"])
                        self.assertEqual(f.attrs["outcome"], b"interrupted")
            for file in sorted(glob.glob(out + "/*.h5"))[-3:]:
                self.done("replay", file, "--verify")
            self.assertEqual(glob.glob(out + "/*.tmp"), [])

    def test_ctrl_c_ends_the_episode_cleanly_and_says_so(self):
        out = self.path("out")
        process = subprocess.Popen([PROGRAM, "record", "--scene", "paper", "--episodes", "1000",
                                    "--out", out], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   text=True)
        process.stdout.readline()
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assertIn("stopped by Ctrl-C", errors)
        self.assertEqual(glob.glob(out + "/*.part"), [])
        for file in sorted(glob.glob(out + "/*.h5"))[-3:]:
            self.done("replay", file, "--verify")

    def test_a_full_disk_is_one_line_and_keeps_what_was_flushed(self):
        out = self.path("out")

        def small_files():
            import resource
            resource.setrlimit(resource.RLIMIT_FSIZE, (3_000_000, 3_000_000))
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)

        # The journal fits and the episode does not, or neither does.
        whole = self.path("whole")
        self.record(whole, episodes=1)
        for limit in (os.path.getsize(glob.glob(whole + "/*.h5")[0]) // 2, 100):
            def tight():
                import resource
                resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
                signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            run = ferrule("record", "--scene", "paper", *QUICK, "--episodes", 1, "--out",
                          self.path(f"tight{limit}"), preexec_fn=tight)
            self.assertEqual(run.returncode, 3, run.stderr)
        run = ferrule("record", "--scene", "paper", "--episodes", 1, "--out", out,
                      preexec_fn=small_files)
        self.assertEqual(run.returncode, 3, run.stderr)
        self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
        self.assertEqual(glob.glob(out + "/*.h5") + glob.glob(out + "/*.tmp"), [])
        recovered = json.loads(self.done("recover", out, "--json").stdout)["recovered"]
        self.assertGreater(recovered[0]["rows"], 4000)
        self.done("replay", recovered[0]["file"], "--verify")

    def test_two_recorders_share_a_folder(self):
        out = self.path("out")
        first = subprocess.Popen([PROGRAM, "record", "--scene", "paper", *QUICK, "--episodes", "6",
                                  "--seed", "1", "--out", out], stdout=subprocess.PIPE, text=True)
        first.stdout.readline()
        second = self.done("record", "--scene", "paper", *QUICK, "--episodes", 6, "--seed", 99,
                           "--out", out, "--append").stdout
        told = first.communicate()[0] + second
        self.assertEqual(first.returncode, 0)
        files = sorted(glob.glob(out + "/*.h5"))
        self.assertEqual(len(files), 12)
        seeds = [int(h5py.File(file).attrs["seed"]) for file in files]
        self.assertEqual((seeds.count(1), seeds.count(99)), (6, 6))
        for file in files[1:]:
            self.assertEqual(told.count(file), 1)

    def test_recover_keeps_a_journal_whose_episode_cannot_be_read(self):
        out = self.path("out")
        process = subprocess.Popen([PROGRAM, "record", "--scene", "paper", "--episodes", "1000",
                                    "--out", out], stdout=subprocess.PIPE)
        process.stdout.readline()
        time.sleep(0.05)
        process.kill()
        process.communicate()
        for part in glob.glob(out + "/*.part"):
            with open(part.replace(".part", ".h5"), "w") as junk:
                junk.write("junk")
            run = ferrule("recover", out)
            self.assertEqual(run.returncode, 3)
            self.assertTrue(os.path.exists(part))
        os.mkdir(out + "/episode_0900.part")
        ferrule("recover", out)

    def test_the_longest_trial_ends_an_operator_that_never_finishes(self):
        out, controller = self.path("out"), self.path("controller.json")
        self.record(out, episodes=6)
        self.done("fit", out, "--out", controller)
        law = json.load(open(controller))
        law["gains"]["end_depth"]["value"] = 8.3e-6 * 250
        json.dump(law, open(controller, "w"))
        run = self.done("record", "--operator", controller, "--scene", "paper", *QUICK, "--set",
                        "limits.time_s=9", "--episodes", 1, "--out", self.path("by_law"), "--json")
        self.assertLessEqual(json.loads(run.stdout)["episodes"][0]["time_s"], 9.001)

    def test_numbers_out_of_range(self):
        for option, value in (("--skill", "nan"), ("--skill", "1.1"), ("--seed", "-1"),
                              ("--seed", "9" * 20), ("--seed", "1.5"), ("--episodes", "0")):
            self.refused(2, "record", option, value, "--out", self.path("x"), says=[option])
        self.assertFalse(os.path.exists(self.path("x")))

    def test_a_folder_that_cannot_be_made(self):
        self.refused(3, "record", "--out", "/proc/nothing/here", says=["/proc/nothing/here"])


class Devices(Case):
    def test_a_machine_without_devices_says_so(self):
        # Where there are some, they are listed; both are fine.
        document = json.loads(self.done("devices", "--json").stdout)
        for device in document["devices"]:
            self.assertIn(device["state"], ("usable", "forbidden", "never used"))
        if not document["devices"]:
            self.assertIn("no device is connected", self.done("devices").stdout)
            for arguments in (["record", "--device", "auto", "--out", self.path("out")],
                              ["devices", "--test"]):
                self.refused(4, *arguments, says=["no device is connected", "fake:spacemouse"])
        self.refused(4, "record", "--device", "/dev/none", "--out", self.path("out"),
                     says=["/dev/none"])
        self.assertFalse(os.path.exists(self.path("out")))

    @unittest.skipUnless(shutil.which("umockdev-run"), "umockdev is not installed")
    def test_connected_devices_are_listed_with_what_they_need(self):
        # Six axes of a multi-axis controller; in a /sys of umockdev's. The second has no node that
        # could be opened, the third is a mouse of the same maker.
        descriptor = "05010908A101850116A2FE265E01" "093009310932093309340935" "751095068102C0"
        text = ""
        for number, product in enumerate((0xC635, 0xC62E, 0xC650)):
            node = f"N: hidraw{number}\n" if number != 1 else ""
            text += (f"P: /devices/{number}\nE: SUBSYSTEM=hid\nE: HID_NAME=mouse {number}\n"
                     f"E: HID_ID=0003:0000256F:{product:08X}\nE: HID_PHYS=\nE: HID_UNIQ=\n"
                     f"H: report_descriptor={descriptor}\n\n"
                     f"P: /devices/{number}/hidraw/hidraw{number}\n{node}"
                     f"E: DEVNAME=/dev/hidraw{number}\nE: SUBSYSTEM=hidraw\n"
                     f"L: device=../../../{number}\n\n")
        with open(self.path("devices"), "w") as out:
            out.write(text)

        def listed(*arguments):
            run = subprocess.run(["umockdev-run", "-d", self.path("devices"), "--", PROGRAM,
                                  "devices", *arguments], capture_output=True, text=True,
                                 timeout=600)
            self.assertEqual(run.returncode, 0, run.stderr)
            return run.stdout

        usable, forbidden, never = json.loads(listed("--json"))["devices"]
        self.assertEqual((usable["path"], usable["id"], usable["kind"], usable["state"]),
                         ("/dev/hidraw0", "256f:c635", "SpaceMouse", "usable"))
        self.assertEqual(usable["name"], "mouse 0")
        self.assertNotIn("udev_rule", usable)
        self.assertEqual(forbidden["state"], "forbidden")
        rule = 'KERNEL=="hidraw*", KERNELS=="*:256F:C62E.*", TAG+="uaccess"'
        self.assertEqual(forbidden["udev_rule"], rule)
        self.assertIn(rule, forbidden["command"])
        self.assertEqual((never["kind"], never["state"]), (None, "never used"))
        text = listed()
        self.assertIn("found, but not permitted", text)
        self.assertIn(forbidden["command"], text)

    def test_a_fake_device_is_shown_live(self):
        for device, axes in (("fake:spacemouse", {"X", "Y", "Z", "Rx", "Ry", "Rz"}),
                             ("fake:pid", {"X", "Y", "Z"})):
            document = json.loads(self.done("devices", "--test", device, "--seconds", 1.5,
                                            "--json").stdout)
            self.assertIn("fake", document["device"])
            self.assertEqual(set(document["axes_moved"]), axes)
            self.assertGreater(document["axes_moved"]["X"]["max"], 100)
            self.assertFalse(document["lost"])
            text = self.done("devices", "--test", device, "--seconds", 1.5).stdout
            self.assertIn("simulated", text)
            self.assertIn("reports/s", text)
            self.assertEqual("force X" in text, device == "fake:pid")

    def test_ctrl_c_ends_the_test_of_a_device(self):
        run = subprocess.Popen([PROGRAM, "devices", "--test", "fake:pid"], stdout=subprocess.PIPE,
                               text=True)
        self.assertIn("fake:pid", run.stdout.readline())
        time.sleep(0.5)
        run.send_signal(signal.SIGINT)
        self.assertEqual(run.wait(timeout=60), 0)
        run.stdout.close()

    def test_a_fake_device_records_with_counts_and_mapping(self):
        for device, motion in (("fake:spacemouse", "velocity"), ("fake:pid", "position")):
            out = self.path(device[5:])
            self.done("record", "--scene", "demo", "--set", "start.distance_um=20", "--set",
                      "success.depth_um=10", "--device", device, "--episodes", 2, "--out", out)
            for file in sorted(glob.glob(out + "/*.h5")):
                with h5py.File(file) as f:
                    self.assertEqual(f.attrs["outcome"], b"inserted")
                    self.assertEqual(f.attrs["operator"].decode(), "simulated hand, " + device)
                    mapping = json.loads(f.attrs["mapping"])
                    self.assertEqual(mapping["motion"], motion)
                    counts = f["data/demo_0/raw/counts"]
                    self.assertEqual(counts.shape, (f["data/demo_0"].attrs["num_samples"], 6))
                    self.assertEqual(counts.dtype, numpy.int64)
                    self.assertGreater(abs(counts[:, 0]).max(), 100)
                self.done("replay", file, "--verify")

    def test_a_simulated_operator_leaves_neither(self):
        with h5py.File(self.record(self.path("out"), episodes=1)[0]) as f:
            self.assertNotIn("mapping", f.attrs)
            self.assertNotIn("raw", f["data/demo_0"])

    def test_gain_moves_the_hand_further(self):
        reach = {}
        for gain in (1, 2):
            out = self.path(str(gain))
            self.done("record", "--scene", "demo", "--set", "start.distance_um=20", "--set",
                      "success.depth_um=10", "--device", "fake:spacemouse", "--gain", gain,
                      "--episodes", 1, "--out", out)
            with h5py.File(out + "/episode_0001.h5") as f:
                reach[gain] = json.loads(f.attrs["mapping"])["gain_m_s"][0][0]
        self.assertAlmostEqual(reach[2] / reach[1], 2)

    def test_usage(self):
        out = ["--out", self.path("out")]
        self.refused(2, "record", "--device", "fake:pid", "--operator", "simulated", *out,
                     says=["--device", "--operator"])
        self.refused(2, "record", "--device", "fake:else", *out, says=["fake:spacemouse"])
        self.refused(2, "record", "--device", "fake:pid", "--gain", 0, *out, says=["--gain"])
        self.refused(2, "devices", "--test", "fake:else", says=["fake:spacemouse"])
        self.refused(2, "devices", "--seconds", 1, says=["--test"])


class Replay(Case):
    def test_a_changed_number_is_reported_at_its_row(self):
        file = self.record(self.path("out"), episodes=1)[0]
        self.done("replay", file)
        self.assertTrue(json.loads(self.done("replay", file, "--verify", "--json").stdout)["identical"])
        with h5py.File(file) as f:
            names = []
            f["data/demo_0"].visititems(
                lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        self.assertGreater(len(names), 14)
        for name in names:
            for row in (0, 321, -1):
                changed = self.path("changed.h5")
                shutil.copy(file, changed)
                with h5py.File(changed, "r+") as f:
                    data = f["data/demo_0/" + name]
                    value = data[row]
                    flat = numpy.atleast_1d(value).copy()
                    if flat.dtype.kind == "f":
                        flat[-1] = numpy.nextafter(flat[-1], flat.dtype.type(1e9))
                    else:
                        flat[-1] += 1
                    data[row] = flat.reshape(numpy.shape(value))
                    expected = row % data.shape[0]
                run = ferrule("replay", changed, "--verify", "--json")
                self.assertEqual(run.returncode, 1, (name, row, run.stderr))
                found = json.loads(run.stdout)["difference"]["row"]
                self.assertLessEqual(abs(found - expected), 1, (name, row))

    def test_flipped_bytes_are_never_taken_for_a_whole_file(self):
        file = self.record(self.path("out"), episodes=1)[0]
        whole = open(file, "rb").read()
        with h5py.File(file) as f:
            data = f["data/demo_0/states"]
            chunk = data.id.get_chunk_info(1)
        draw = random.Random(1)
        for _ in range(25):
            changed = bytearray(whole)
            at = chunk.byte_offset + draw.randrange(chunk.size)
            changed[at] ^= 1 << draw.randrange(8)
            with open(self.path("flipped.h5"), "wb") as out:
                out.write(changed)
            run = ferrule("replay", self.path("flipped.h5"), "--verify")
            self.assertIn(run.returncode, (1, 3), at)
        for _ in range(60):  # anywhere: no crash, no hang
            changed = bytearray(whole)
            for _ in range(20):
                changed[draw.randrange(len(changed))] ^= 1 << draw.randrange(8)
            with open(self.path("flipped.h5"), "wb") as out:
                out.write(changed)
            run = ferrule("replay", self.path("flipped.h5"), "--verify")
            self.assertIn(run.returncode, (0, 1, 2, 3), run.stderr)

    def test_not_an_episode(self):
        with open(self.path("x.h5"), "w") as out:
            out.write("hello")
        self.refused(3, "replay", self.path("x.h5"), says=["x.h5"])
        with h5py.File(self.path("y.h5"), "w") as f:
            f["a"] = 1
        self.refused(3, "replay", self.path("y.h5"), says=["not a ferrule episode"])
        self.refused(3, "replay", self.path("z.h5"), says=["z.h5"])


class Score(Case):
    def test_a_session_is_scored_listed_and_drawn(self):
        out = self.path("out")
        self.record(out, "--skill", 0.9, episodes=3)
        self.record(out, "--skill", 0.2, "--append", "--set", "limits.force_uN=0.5", episodes=2)
        result = json.loads(self.done("score", out, "--json").stdout)["episodes"]
        self.assertEqual([e["file"] for e in result], sorted(glob.glob(out + "/*.h5")))
        self.assertEqual([e["outcome"] == "inserted" for e in result], [True] * 3 + [False] * 2)
        for part in result[0]["parts"]:
            self.assertEqual(max(e["parts"][part] for e in result[:3]), 1)
        for e in result:
            mean = sum(e["parts"].values()) / len(e["parts"])
            factor = 1 if e["outcome"] == "inserted" else 0.5 * e["completion"]
            self.assertAlmostEqual(e["score"], 100 * mean * factor, delta=1e-9)
            with h5py.File(e["file"]) as f:
                demo = f["data/demo_0"]
                force = demo["rows/holder_wrench"][:, :3] - demo["rows/forces"][:, 6:9]
                peak = numpy.linalg.norm(force, axis=1).max() * 1e6
                self.assertAlmostEqual(e["peak_force_uN"] / peak, 1, delta=1e-9)
                touches = (demo["states"][:, 13] + demo["states"][:, 19]) > 0
                self.assertAlmostEqual(e["contact_time_s"], touches.sum() * 1e-3, delta=1e-9)
        plot = self.path("curve.svg")
        table = self.done("score", out, "--plot", plot).stdout
        self.assertEqual(table.count("\n"), 6)
        self.assertIn("</svg>", open(plot).read())

    def test_what_cannot_be_scored(self):
        out = self.path("out")
        self.refused(3, "score", out, says=["out"])
        os.mkdir(out)
        self.refused(2, "score", out, says=["no episodes"])
        files = self.record(out, "--set", "limits.force_uN=0.2", episodes=1)
        result = json.loads(self.done("score", out, "--json").stdout)["episodes"]
        self.assertIsNone(result[0]["score"])
        self.assertIn("no episode succeeded", self.done("score", out).stdout)
        self.refused(2, "score", out, "--plot", self.path("none.svg"), says=["no episode succeeded"])
        with open(files[0], "r+b") as f:
            f.truncate(os.path.getsize(files[0]) // 2)
        self.refused(3, "score", out, says=["episode_0001.h5"])


class Learning(Case):
    KEYS = {"trials", "successes", "success_rate", "wilson_low", "wilson_high", "outcomes", "time_s",
            "peak_force_uN", "loss_dB"}

    def test_record_fit_evaluate(self):
        out, controller = self.path("out"), self.path("controller.json")
        self.record(out, episodes=6)
        self.assertIn("ramp_time", self.done("fit", out, "--out", controller).stdout)
        again = self.path("again.json")
        self.done("fit", out, "--out", again, "--json")
        self.assertEqual(open(controller).read(), open(again).read())

        arguments = ["evaluate", controller, "--scene", "paper", *QUICK, "--trials", 30, "--seed", 9,
                     "--json", "--baseline", "constant-velocity"]
        outputs = {self.done(*arguments, "--threads", n).stdout for n in (1, 2, 5, 0)}
        self.assertEqual(len(outputs), 1)
        result = json.loads(outputs.pop())
        for part in (result, result["baseline"]):
            self.assertTrue(self.KEYS <= set(part))
            self.assertEqual(sum(part["outcomes"].values()), 30)
            self.assertEqual(part["outcomes"].get("inserted", 0), part["successes"])
        self.assertIn("mcnemar_p", result["baseline"])
        alone = json.loads(self.done("evaluate", "--baseline", "constant-velocity", "--scene",
                                     "paper", *QUICK, "--trials", 30, "--seed", 9, "--json").stdout)
        for key in self.KEYS:
            self.assertEqual(alone[key], result["baseline"][key])

    def test_a_recorded_controller_is_fitted_back(self):
        out, first, second = self.path("out"), self.path("first.json"), self.path("second.json")
        self.record(out, episodes=6)
        self.done("fit", out, "--out", first)
        known = json.load(open(first))
        known["gains"]["yield_y"]["value"] = 8.8e-4
        known["gains"]["slowing"]["value"] = 0.21
        known["gains"]["yield_x"]["value"] = 1.3e-4
        json.dump(known, open(first, "w"))
        by_law = self.path("by_law")
        self.done("record", "--operator", first, "--scene", "paper", *QUICK, "--episodes", 6,
                  "--out", by_law)
        self.done("fit", by_law, "--out", second)
        back = json.load(open(second))
        for name, gain in known["gains"].items():
            self.assertAlmostEqual(back["gains"][name]["value"] / gain["value"], 1, delta=1e-6,
                                   msg=name)

    def test_a_supervisor_is_asked_for_and_says_what_it_did(self):
        arguments = ["evaluate", "--baseline", "constant-velocity", "--trials", 12, "--seed", 5]
        alone = json.loads(self.done(*arguments, "--json").stdout)
        self.assertNotIn("interventions", alone)
        kept, again = (self.done(*arguments, "--json", "--supervise", "--threads", n).stdout
                       for n in (1, 2))
        self.assertEqual(kept, again)
        kept = json.loads(kept)
        self.assertGreater(kept["successes"], alone["successes"])
        self.assertEqual(kept["trials_with_interventions"], 12)
        self.assertEqual(kept["interventions"]["acceleration"]["trials"], 12)
        self.assertEqual(kept["interventions"]["retreat"]["count"],
                         sum(kept["interventions"][kind]["count"] for kind in ("held", "jam")) -
                         kept["outcomes"].get("gave_up", 0))
        self.assertEqual(sum(kept["gave_up"].values()), kept["outcomes"].get("gave_up", 0))
        self.assertIn("retreat", self.done(*arguments, "--supervise").stdout)
        self.refused(2, "record", "--supervise", "--out", self.path("out"), says=["--supervise"])

    def test_a_law_is_chosen_drawn_and_run(self):
        out, controller, plot = self.path("out"), self.path("c.json"), self.path("law.svg")
        self.record(out, episodes=6)
        run = self.done("fit", out, "--law", "auto", "--out", controller, "--plot", plot, "--json")
        fitted = json.loads(run.stdout)
        table = fitted["metrics"]["cross_validation"]
        self.assertEqual(set(table), {"linear", "insertion", "phased", "saturated"})
        best = min(table.values(), key=lambda law: law["error_m_s"])
        for law in table.values():  # none with fewer gains is as good
            if law["gains"] < table[fitted["law"]]["gains"]:
                self.assertGreater(law["error_m_s"],
                                   best["error_m_s"] + best["standard_error_m_s"])
        self.assertEqual(len(fitted["gains"]), table[fitted["law"]]["gains"])
        text = open(plot).read()
        self.assertIn("</svg>", text)
        self.assertIn("felt F_y [N]", text)
        for law in ("linear", "saturated"):
            run = self.done("fit", out, "--law", law, "--out", controller)
            self.assertIn("law: " + law, run.stdout)
            self.assertEqual(json.load(open(controller))["law"], law)
            self.done("evaluate", controller, "--scene", "paper", *QUICK, "--trials", 3)
        self.refused(2, "fit", out, "--law", "cubic", "--out", controller, says=["cubic"])

    def test_parameters_of_the_scene_are_identified(self):
        out, key = self.path("out"), "laws.friction.burgers_nm"
        self.record(out)
        arguments = ["identify", out, "--parameters", key + ",ferrule.length_mm"]
        run = self.done(*arguments, "--set", key + "=0.8", "--json")
        found = json.loads(run.stdout)
        self.assertAlmostEqual(found["parameters"][key]["value"], 0.48, delta=1e-4)
        self.assertEqual(found["parameters"][key]["start"], 0.8)
        self.assertEqual(found["parameters"][key]["told"], "fitted")
        self.assertEqual(found["parameters"]["ferrule.length_mm"]["told"], "open")
        self.assertIsNone(found["parameters"]["ferrule.length_mm"]["value"])
        self.assertEqual(len(found["episodes"]), 3)
        self.assertIn("tell nothing about it", self.done(*arguments, "--scene", "paper").stdout)
        self.refused(2, "identify", out, "--parameters", "laws.friction.b", says=["laws.friction.b"])
        self.refused(2, "identify", out, says=["--parameters"])
        os.remove(out + "/episode_0001.h5")
        self.refused(2, *arguments, says=["too few episodes"])

    def test_refusals(self):
        out = self.path("out")
        self.record(out, episodes=2)
        self.refused(2, "fit", out, "--out", self.path("c.json"), says=["too few demonstrations"])
        self.assertFalse(os.path.exists(self.path("c.json")))
        self.refused(3, "fit", self.path("none"), "--out", self.path("c.json"), says=["none"])
        self.refused(3, "evaluate", self.path("none.json"), says=["none.json"])
        for text, code in (("{}", 2), ("", 2), ('{"format": "ferrule controller"}', 2)):
            with open(self.path("bad.json"), "w") as f:
                f.write(text)
            self.refused(code, "evaluate", self.path("bad.json"), says=["bad.json"])


class Policies(Case):
    """Slow; only in the release build."""

    @classmethod
    def setUpClass(cls):
        cls.shared = tempfile.mkdtemp(prefix="ferrule-test-")
        cls.addClassCleanup(shutil.rmtree, cls.shared, ignore_errors=True)
        cls.episodes, cls.law = cls.shared + "/episodes", cls.shared + "/law.json"
        cls.file = cls.shared + "/c.json"
        run = ferrule("record", "--scene", "demo", "--skill", 0.8, "--episodes", 20, "--out",
                      cls.episodes)
        assert run.returncode == 0, run.stderr
        run = ferrule("fit", cls.episodes, "--out", cls.law)
        assert run.returncode == 0, run.stderr
        run = ferrule("fit", cls.episodes, "--method", "torch", "--ensemble", 2, "--out", cls.file,
                      "--plot", cls.shared + "/training.svg")
        cls.torch = run.returncode == 0
        if not cls.torch:
            assert run.returncode == 2 and "libtorch-dev" in run.stderr, run.stderr

    def needs_torch(self):
        if not self.torch:
            self.skipTest("built without libtorch")

    # Five of the episodes, for what need not be good.
    def few(self):
        folder = self.path("few")
        os.mkdir(folder)
        for file in sorted(glob.glob(self.episodes + "/*.h5"))[:5]:
            shutil.copy(file, folder)
        return folder

    # An independent reader of both files.
    def read(self, file):
        controller = json.load(open(file))
        data = open(os.path.join(os.path.dirname(file), controller["weights"]), "rb").read()
        self.assertEqual(hashlib.sha1(data).hexdigest(), controller["weights_sha1"])
        length = int.from_bytes(data[:8], "little")
        header = json.loads(data[8:8 + length])
        arrays = {}
        for name, entry in header.items():
            if name != "__metadata__":
                self.assertEqual(entry["dtype"], "F32")
                first, last = entry["data_offsets"]
                arrays[name] = numpy.frombuffer(data[8 + length + first:8 + length + last],
                                                "<f4").reshape(entry["shape"]).astype(float)
        return controller, arrays

    # Inputs of the policy at every row of an episode.
    def inputs(self, controller, felt, depth):
        columns = []
        for k in range(controller["history"]["samples"]):
            late = numpy.zeros_like(felt)
            shift = k * controller["history"]["spacing_periods"]
            late[shift:] = felt[:len(felt) - shift]
            columns.append(late)
        return numpy.column_stack(columns + [depth])

    def answer(self, controller, arrays, inputs):
        samples = controller["history"]["samples"]
        scales = controller["inputs"][:5] * samples + controller["inputs"][5:]
        z = (inputs - [c["mean"] for c in scales]) / [c["scale"] for c in scales]
        mean = 0
        for m in range(controller["ensemble"]):
            h = z
            for i in range(len(controller["hidden"]) + 1):
                name = f"members.{m}.layers.{i}."
                h = h @ arrays[name + "weight"].T + arrays[name + "bias"]
                h = numpy.tanh(h) if i < len(controller["hidden"]) else h
            mean = mean + h[:, :3] / controller["ensemble"]
        out = controller["outputs"]
        velocity = mean * [c["scale"] for c in out] + [c["mean"] for c in out]
        speed = numpy.linalg.norm(velocity, axis=1, keepdims=True)
        return velocity * numpy.minimum(1, controller["limits"]["speed_m_s"] / speed)

    # What the controller of `file` felt and did: wrench at the hand, depth, time, velocity.
    def recorded(self, file):
        out = self.path("by " + os.path.basename(file))
        self.done("record", "--operator", file, "--scene", "demo", "--episodes", 1, "--seed", 5,
                  "--set", "limits.speed_um_s=1000", "--out", out)
        with h5py.File(out + "/episode_0001.h5") as f:
            demo = f["data/demo_0"]
            x, force = f.attrs["alpha_x"], f.attrs["alpha_f"]
            wrench = demo["rows/holder_wrench"][:] * [force] * [1, 1, 1, x, x]
            pose = demo["rows/hand_pose"][:]
            return (wrench - wrench[0], numpy.maximum(0, -pose[:, 0]),
                    demo["rows/time"][:].ravel(), demo["rows/command"][:, :3])

    def close(self, a, b, tolerance=1e-6):
        self.assertGreater(len(a), 1000)
        scale = numpy.abs(b).max(axis=0)
        self.assertLessEqual((numpy.abs(a - b) / scale).max(), tolerance)

    def test_a_fitted_policy_inserts_far_more_often_than_constant_velocity(self):
        self.needs_torch()
        result = json.loads(self.done("evaluate", self.file, "--scene", "demo", "--trials", 25,
                                      "--baseline", "constant-velocity", "--json").stdout)
        self.assertGreater(result["baseline"]["difference_low"], 0.1)
        self.assertLess(result["baseline"]["mcnemar_p"], 1e-2)

    def test_files_are_of_the_schema_and_say_what_they_were_trained_on(self):
        schema = json.load(open(SOURCE + "/data/controller.schema.json"))
        jsonschema.Draft202012Validator.check_schema(schema)
        validator = jsonschema.Draft202012Validator(schema)
        validator.validate(json.load(open(self.law)))
        self.needs_torch()
        controller, _ = self.read(self.file)
        validator.validate(controller)
        told = controller["trained_on"]
        self.assertEqual(len(told["episodes"]) + len(told["held_out"]), 20)
        for episode in told["episodes"] + told["held_out"]:
            data = open(episode["file"], "rb").read()
            self.assertEqual(hashlib.sha1(data).hexdigest(), episode["sha1"])
        self.assertIn("</svg>", open(self.shared + "/training.svg").read())

    def test_schema_and_program_agree_on_broken_controllers(self):
        self.needs_torch()
        validator = jsonschema.Draft202012Validator(
            json.load(open(SOURCE + "/data/controller.schema.json")))
        good, paths, draw = json.load(open(self.file)), [], random.Random(2)

        def walk(node, path):
            for key in node if isinstance(node, dict) else range(len(node)):
                paths.append(path + [key])
                if isinstance(node[key], (dict, list)):
                    walk(node[key], path + [key])

        walk(good, [])
        file, refused = self.path("broken.json"), 0
        shutil.copy(self.shared + "/c.safetensors", self.folder)
        for _ in range(60):
            bad, path = copy.deepcopy(good), draw.choice(paths)
            # What no schema can say: what belongs to the weights.
            if path[0] in ("weights", "weights_sha1", "ensemble", "hidden") or path[-1] == "samples":
                continue
            place = bad
            for key in path[:-1]:
                place = place[key]
            if draw.randrange(3) == 0:
                del place[path[-1]]
            else:
                place[path[-1]] = draw.choice([-1, 0, "text", None, [], {}, True, 1e300, 0.3, 7])
            json.dump(bad, open(file, "w"))
            run = ferrule("export", file, "--header", self.path("x.h"))
            self.assertIn(run.returncode, (0, 2), run.stderr)
            self.assertEqual(run.returncode == 0, validator.is_valid(bad), (path, run.stderr))
            self.assertEqual(run.stderr.count("\n"), run.returncode != 0, run.stderr)
            refused += run.returncode != 0
        self.assertGreater(refused, 20)

    def test_the_same_command_gives_the_same_bytes(self):
        self.needs_torch()
        few, texts = self.few(), []
        for _ in range(2):
            self.done("fit", few, "--method", "torch", "--ensemble", 2, "--out", self.path("c.json"))
            texts.append([open(self.path(name), "rb").read()
                          for name in ("c.json", "c.safetensors")])
        self.assertEqual(*texts)

    def test_the_weights_give_the_same_answers_to_another_reader(self):
        self.needs_torch()
        controller, arrays = self.read(self.file)
        felt, depth, _, velocity = self.recorded(self.file)
        self.close(self.answer(controller, arrays, self.inputs(controller, felt, depth)), velocity)

    def test_torchscript_answers_alike_in_python(self):
        self.needs_torch()
        try:
            import torch
        except ImportError:
            self.skipTest("no torch for Python")
        script = self.path("c.pt")
        self.done("export", self.file, "--torchscript", script)
        felt, depth, _, velocity = self.recorded(self.file)
        controller, _ = self.read(self.file)
        inputs = torch.from_numpy(self.inputs(controller, felt, depth))
        answer, deviation, disagreement = torch.jit.load(script)(inputs)
        self.close(answer.numpy(), velocity)
        self.assertTrue((deviation.numpy() > 0).all() and (disagreement.numpy() >= 0).all())
        self.refused(2, "export", self.law, "--torchscript", script, says=["law.json", "network"])

    # Feeds the header's controller what the recorded one felt.
    def by_header(self, file):
        header, source, program = self.path("c.h"), self.path("c.c"), self.path("c")
        self.done("export", file, "--header", header)
        with open(source, "w") as out:
            out.write('''#include "c.h"
#include <stdio.h>
int main(void) {
  ferrule_state s;
  double w[5], d, t, v[5];
  ferrule_start(&s);
  while (scanf("%lf %lf %lf %lf %lf %lf %lf", w, w + 1, w + 2, w + 3, w + 4, &d, &t) == 7) {
    ferrule_command(&s, w, d, t, v);
    printf("%.17g %.17g %.17g\\n", v[0], v[1], v[2]);
  }
  return 0;
}
''')
        subprocess.run(["cc", "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1", source,
                        "-o", program, "-lm"], check=True)
        felt, depth, t, velocity = self.recorded(file)
        rows = "\n".join(" ".join(f"{x:.17g}" for x in row)
                         for row in numpy.column_stack([felt, depth, t]))
        run = subprocess.run([program], input=rows, capture_output=True, text=True, check=True)
        self.close(numpy.array([line.split() for line in run.stdout.splitlines()], float), velocity)

    def test_the_header_of_a_law_answers_alike(self):
        self.by_header(self.law)

    def test_the_header_of_a_policy_answers_alike(self):
        self.needs_torch()
        self.by_header(self.file)

    def test_rounds_of_dagger(self):
        self.needs_torch()
        out = self.path("d.json")
        few = self.few()
        self.done("fit", few, "--method", "torch", "--out", out)
        before = json.load(open(out))["trained_on"]["rows"]
        self.done("fit", few, "--method", "torch", "--dagger", 1, "--out", out)
        controller, _ = self.read(out)
        [told] = controller["metrics"]["dagger"]
        self.assertEqual(told["trials"], 10)
        self.assertGreater(told["rows"], 1000)
        self.assertEqual(controller["trained_on"]["rows"], before + told["rows"])

    def test_refusals(self):
        self.refused(2, "fit", self.episodes, "--ensemble", 2, "--out", self.path("x.json"),
                     says=["--ensemble", "--method torch"])
        self.refused(2, "export", self.law, says=["--torchscript", "--header"])
        self.refused(3, "export", self.path("none.json"), "--header", self.path("x.h"),
                     says=["none.json"])
        self.assertFalse(os.path.exists(self.path("x.h")))
        self.needs_torch()
        self.refused(2, "fit", self.episodes, "--method", "torch", "--out", self.path("x.safetensors"),
                     says=[".safetensors"])
        good = open(self.shared + "/c.safetensors", "rb").read()
        shutil.copy(self.file, self.folder)
        for bad in (b"", good[:7], good[:100], good[:-4], good + b"0000", b"\xff" * 8 + good[8:],
                    good[:-4] + b"\x00\x00\xc0\x7f", good[:-1] + bytes([good[-1] ^ 1])):
            with open(self.path("c.safetensors"), "wb") as out:
                out.write(bad)
            self.refused(2, "evaluate", self.path("c.json"), says=["c.safetensors"])


class Doctor(Case):
    def setUp(self):
        super().setUp()
        self.schema = json.load(open(SOURCE + "/data/devices/device.schema.json"))
        jsonschema.Draft202012Validator.check_schema(self.schema)
        self.validator = jsonschema.Draft202012Validator(self.schema)
        self.pen = json.load(open(SOURCE + "/data/devices/pen.json"))

    def doctor(self, code, *arguments):
        run = ferrule("doctor", "--seconds", 0.02, "--json", *arguments)
        self.assertEqual(run.returncode, code, run.stderr)
        return json.loads(run.stdout)

    def device(self, **changes):
        file = self.path("device.json")
        with open(file, "w") as out:
            json.dump({**self.pen, **changes}, out)
        return file

    def test_the_numbers_follow_from_scene_and_device(self):
        d = self.doctor(0, "--scene", "demo", "--device", "pen")
        self.assertTrue(d["stable"])
        self.assertEqual(d["reasons"], [])
        # Nearly rigid contacts: the holder's 0.5 N/m, magnified 8.46e5/250 times.
        self.assertLess(abs(d["felt"]["stiffness_N_m"] / 1692 - 1), 0.03)
        self.assertLess(abs(d["bounds"]["damping_needed_N_s_m"] /
                            (d["felt"]["stiffness_N_m"] * 1e-3 / 2) - 1), 1e-9)
        self.assertAlmostEqual(d["bounds"]["quantised_stiffness_N_m"], 2 * 0.04 / 30e-6, delta=1e-6)
        self.assertGreater(d["tip"]["two_point"], 10)
        self.assertEqual(d["loop"]["periods"], 20)
        self.assertLessEqual(d["loop"]["p50_us"], d["loop"]["worst_us"])
        self.doctor(0, "--set", "success.depth_um=1")  # shallow: the tilts stay small
        late = self.doctor(1, "--device", self.device(delay_periods=4))
        self.assertLess(abs(late["bounds"]["damping_needed_N_s_m"] /
                            d["bounds"]["damping_needed_N_s_m"] - 9), 1e-6)

    def test_every_refused_scene_is_stable_with_the_scaling_it_is_told(self):
        weak = self.device(damping_N_s_m=0.4)
        slow = self.device(rate_Hz=200, coulomb_N=0.01)
        for scene, device in (("bench", "pen"), ("epoxy", "pen"), ("demo", weak), ("paper", slow)):
            d = self.doctor(1, "--scene", scene, "--device", device)
            self.assertFalse(d["stable"])
            self.assertTrue(d["reasons"])
            again = self.doctor(0, "--scene", scene, "--device", device, *d["set"].split())
            self.assertTrue(again["stable"])
            more = f"scaling.hand_force_N={1.02 * d['largest_hand_force_N']}"
            self.doctor(1, "--scene", scene, "--device", device, "--set", more)

    def test_text_says_refused_and_why(self):
        run = ferrule("doctor", "--scene", "bench", "--seconds", 0.02)
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertIn("REFUSED for force feedback", run.stdout)
        self.assertIn("--set scaling.hand_force_N=", run.stdout)
        run = self.done("doctor", "--scene", "demo", "--seconds", 0.02)
        self.assertIn("STABLE", run.stdout)

    def test_schema_and_program_agree_on_profiles(self):
        for file in glob.glob(SOURCE + "/data/devices/*.json"):
            if not file.endswith(".schema.json"):
                self.validator.validate(json.load(open(file)))
        for key in self.pen:
            for value in (-1, "text", None, True) if key != "rate_Hz" else (9, 1e6):
                file = self.device(**{key: value})
                if self.validator.is_valid(json.load(open(file))):
                    continue
                self.refused(2, "doctor", "--device", file, says=[f"{file}: {key} = "])
        for key in ("damping_N_s_m", "coulomb_N", "resolution_um", "delay_periods"):
            file = self.device(**{key: 0})
            self.validator.validate(json.load(open(file)))
            run = ferrule("doctor", "--seconds", 0.01, "--device", file)
            self.assertIn(run.returncode, (0, 1), run.stderr)
        self.refused(2, "doctor", "--device", self.device(surprise=1), says=["unknown key"])
        self.refused(3, "doctor", "--device", "nothing", says=["nothing", "pen"])
        self.refused(2, "doctor", "--seconds", "0", says=["--seconds"])


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
        self.assertNotRegex(html, r"(src|href)=\"(?!data:)")
        self.assertEqual(html.count("<figure>"), 5)
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


class Install(Case):
    """Slow; only in the release build."""

    def test_an_outside_project_finds_the_package_and_steps_a_scene(self):
        prefix = self.path("prefix")
        subprocess.run(["cmake", "--install", BUILD, "--prefix", prefix], check=True,
                       stdout=subprocess.DEVNULL)
        listing = subprocess.run([prefix + "/bin/ferrule", "forces", "--scene", "dry", "--json"],
                                 capture_output=True, text=True, check=True).stdout
        self.assertEqual(json.loads(listing)["scene"], "dry")
        outside = self.path("outside")
        shutil.copytree(SOURCE + "/tests/outside", outside)
        subprocess.run(["cmake", "-S", outside, "-B", outside + "/build", "-G", "Ninja",
                        "-DCMAKE_PREFIX_PATH=" + prefix, "-DCMAKE_BUILD_TYPE=Release"], check=True,
                       stdout=subprocess.DEVNULL)
        subprocess.run(["cmake", "--build", outside + "/build"], check=True,
                       stdout=subprocess.DEVNULL)
        run = subprocess.run([outside + "/build/outside", prefix + "/share/ferrule/scenes/paper.json"],
                             capture_output=True, text=True, check=True)
        self.assertIn("inserted", run.stdout)


if __name__ == "__main__":
    words = [w for w in sys.argv[1:] if not w.startswith("-")]
    PROGRAM, SOURCE = os.path.abspath(words[1]), os.path.abspath(words[2])
    BUILD = os.path.abspath(words[3])
    unittest.main(argv=[sys.argv[0], words[0], "-v"], warnings="ignore")
