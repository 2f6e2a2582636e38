import csv
import io
import json
import math
import os
import re
from xml.etree import ElementTree

import h5py
import numpy

from case import QUICK, SOURCE, Case, main


FORCES = ["forces", "--scene", "paper"]


class Forces(Case):
    def test_curves_are_the_printed_formulas(self):
        hamaker, volts, gamma, angle, film = 1.3e-19, 0.37, 0.031, math.radians(41), 55e-9
        run = self.done(*FORCES, "--gap-nm", "1:500:50:log", "--length-um", 73, "--json",
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
        rows = json.loads(self.done(*FORCES, "--depth-nm", "0:10:11", "--json").stdout)["rows"]
        self.assertEqual([row["depth_nm"] for row in rows], list(range(11)))
        for row, adhesion, friction in ((rows[0], -5.574418828, 0.1296897463),
                                        (rows[10], -7.830277437, 0.1728765087)):
            self.assertAlmostEqual(row["adhesion_uN"] / adhesion, 1, delta=2e-9)
            self.assertAlmostEqual(row["friction_uN"] / friction, 1, delta=2e-9)

    def test_forces_grow_in_a_straight_line_with_the_inserted_length(self):
        rows = json.loads(self.done(*FORCES, "--length-um", "0:200:21", "--json").stdout)["rows"]
        for row in rows:
            self.assertAlmostEqual(row["capillary_uN"], rows[10]["capillary_uN"] *
                                   row["length_um"] / 100, delta=1e-9)

    def test_a_tilted_fibre_feels_the_mean_over_its_gaps(self):
        scene = ["--json", "--set", "laws.van_der_waals.form=corrected",
                 "--set", "laws.electrostatic.form=corrected",
                 "--set", "laws.capillary.form=corrected"]
        tilted = json.loads(self.done(*FORCES, "--gap-nm", 10, "--length-um", 100,
                                      "--tilt-mrad", 1, *scene).stdout)["rows"][0]
        gaps = 4000
        rows = json.loads(self.done(*FORCES, "--length-um", 100, "--gap-nm",
                                    f"{10 + 50 / gaps}:{110 - 50 / gaps}:{gaps}",
                                    *scene).stdout)["rows"]
        for name in ("van_der_waals_uN", "electrostatic_uN", "capillary_uN"):
            mean = sum(row[name] for row in rows) / gaps
            self.assertLess(mean, 0)
            self.assertLessEqual(abs(tilted[name] / mean - 1), 1e-3, name)

    def test_a_bridge_along_a_tilted_fibre_gives_its_energy_over_the_way(self):
        # f = -dw/dh with w = -4 gamma cos(theta) x, so that its mean is that difference of w, for
        # a bridge that ruptures on the way too, and for the one beyond the axis.
        gamma, volume, rupture, c = 0.072, 2e-13, 210e-9, 500e-9
        radius = 62.5e-6 * 63e-6 / c

        def energy(h):
            h = min(h, 2 * c - h, rupture)
            low, high = 0, 1e-3
            for _ in range(200):
                x = (low + high) / 2
                low, high = (x, high) if 2 * (h * x + x**3 / (6 * radius)) < volume else (low, x)
            return -4 * gamma * 0.5 * low

        for gap, tilt in ((10, 1), (10, 3), (1, 9.9), (200, 0.5), (0.2, 0.01)):
            row = json.loads(self.done(
                *FORCES, "--form", "corrected", "--gap-nm", gap, "--length-um", 100,
                "--tilt-mrad", tilt, "--json", "--set", f"laws.capillary.volume_per_length_m2={volume}",
                "--set", "laws.capillary.rupture_nm=210").stdout)["rows"][0]
            h, rise = 1e-9 * gap, 100e-6 * 1e-3 * tilt
            force = (energy(h) - energy(h + rise)) / rise * 100e-6
            self.assertAlmostEqual(row["capillary_uN"] / (1e6 * force), 1, delta=1e-7)

    def test_a_gap_that_cannot_be_the_smallest_is_refused(self):
        for gap in (501, 1000, 1500):
            self.refused(2, *FORCES, "--form", "corrected", "--gap-nm", gap,
                         says=["--gap-nm", "clearance, 500 nm"])
        self.refused(2, *FORCES, "--gap-nm", 10, "--tilt-mrad", 9.9, says=["9.8 mrad"])
        self.done(*FORCES, "--form", "corrected", "--gap-nm", 500)
        self.done(*FORCES, "--gap-nm", 10, "--tilt-mrad", 9.8)
        self.done(*FORCES, "--gap-nm", 1500)  # the printed laws know one wall
        viscous = '"form": "corrected", "viscosity_Pa_s": 1'
        for law in ("drag={%s}" % viscous, 'flow={%s, "bore": "open", "fluid": "gas"}' % viscous):
            self.refused(2, *FORCES, "--gap-nm", 1500, "--set", f"laws.{law}",
                         says=["--gap-nm", "clearance, 500 nm"])  # they know where the fibre is

    def test_liquid_in_the_gap(self):
        mu, gamma, angle, length, v = 0.7, 0.031, math.radians(35), 130e-6, 3e-6
        row = json.loads(self.done(
            "forces", "--scene", "epoxy", "--gap-nm", 120, "--length-um", 130, "--speed-um-s", 3,
            "--set", "roughness_nm=0", "--set", f"laws.drag.viscosity_Pa_s={mu}", "--set",
            f"laws.meniscus.surface_tension_N_m={gamma}", "--set",
            "laws.meniscus.contact_angle_deg=35", "--json").stdout)["rows"][0]
        r, c = 62.5e-6, 500e-9
        couette = squeeze = 0
        n = 20000
        for i in range(n):  # around the film of thickness c - e cos
            cosine = math.cos(2 * math.pi * (i + 0.5) / n)
            h = c - (c - 120e-9) * cosine
            couette += 2 * math.pi * r * length * mu * v / h / n
            squeeze += 2 * math.pi * r * length**3 * mu * v * cosine**2 / h**3 / n
        self.assertAlmostEqual(row["drag_uN"] / (1e6 * couette), 1, delta=1e-6)
        self.assertAlmostEqual(row["squeeze_uN"] / (1e6 * squeeze), 1, delta=1e-6)
        self.assertAlmostEqual(row["meniscus_uN"] / (2e6 * math.pi * r * gamma * math.cos(angle)), 1,
                               delta=1e-9)
        table = self.done("forces", "--scene", "epoxy").stdout
        self.assertIn("squeeze", table)
        self.assertNotIn("squeeze", self.done(*FORCES).stdout)

    def test_plot_is_a_drawing(self):
        file = self.path("plot.svg")
        for sweep in (["--gap-nm", "1:500:50:log"], ["--length-um", "0:200:21"],
                      ["--depth-nm", "0:10:11"]):
            self.done(*FORCES, *sweep, "--plot", file)
            text = open(file).read()
            self.assertIn("</svg>", text)
            self.assertGreater(text.count("<path"), 5)
        self.refused(2, *FORCES, "--gap-nm", "1:9:9", "--plot", self.path("plot.png"), says=["--plot", ".svg"])
        self.assertFalse(os.path.exists(self.path("plot.png")))

    def test_curves_stand_where_their_numbers_are(self):
        file = self.path("plot.svg")
        for sweep, key, scale in ((["--gap-nm", "1:500:40:log"], "gap_nm", math.log10),
                                  (["--length-um", "0:200:21"], "length_um", float)):
            rows = json.loads(self.done(*FORCES, *sweep, "--plot", file, "--json").stdout)["rows"]
            plot = ElementTree.parse(file).getroot()
            svg = "{http://www.w3.org/2000/svg}"
            texts = [(t, t.text) for t in plot.iter(svg + "text") if re.fullmatch(r"-?[\d.]+(e[-+]\d+)?", t.text)]
            inner, = plot.findall(svg + "svg")
            left, top = (float(inner.get(at)) - float(inner.get("viewBox").split()[k]) for k, at in enumerate("xy"))
            across = [(scale(float(text)), float(t.get("x"))) for t, text in texts if t.get("text-anchor") == "middle"]
            down = [(scale(float(text)), float(t.get("y")) - 5) for t, text in texts if t.get("text-anchor") == "end"]
            self.assertGreater(min(len(across), len(down)), 2)
            (a, b), (c, d) = (numpy.polyfit(*zip(*ticks), 1) for ticks in (across, down))
            for at, pixel in across:  # they stand evenly
                self.assertAlmostEqual(a * at + b, pixel, delta=0.2)
            curves = [path.get("d") for path in inner.findall(svg + "path")]
            names = [t.text for t in plot.iter(svg + "text") if t.get("text-anchor") == "start"]
            self.assertEqual(len(curves), len(names))
            for curve, name in zip(curves, names):
                points = numpy.array([[float(x) for x in point.split(",")] for point in re.split("[ML]", curve)[1:]])
                values = [(row[key], abs(row[name.replace(" ", "_").lower() + "_uN"])) for row in rows]
                for x, y in values:
                    if y > 0:
                        place = a * scale(x) + b - left, c * scale(y) + d - top
                        self.assertLess(min(math.dist(place, point) for point in points), 0.5, (name, x, y))

    def test_panels_without_a_point_are_left_out(self):
        file = self.path("plot.svg")
        self.done("sweep", "constant-velocity", "ferrule.bore_diameter_um=126,127", "--scene", "bench", "--set",
                  "start.lateral_mean_um=[150,0]", "--trials", 3, "--plot", file)  # beside the cone: nothing goes in
        self.assertIn("inserted", open(file).read())
        self.assertNotIn("mated", open(file).read())

    def test_corrected_forms_are_those_of_the_literature(self):
        lengths = 100e-6
        run = self.done(*FORCES, "--form", "corrected", "--set",
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
        self.refused(2, *FORCES, "--form", "corrected", "--set", "laws.capillary.rupture_nm=100",
                     says=["laws.capillary.rupture_nm = 100", "film_nm"])
        self.refused(2, *FORCES, "--form", "printed", "--set",
                     'laws.drag={"form": "corrected", "viscosity_Pa_s": 1}', says=["drag"])

    def test_settings_are_those_of_the_form(self):
        # Maugis at lambda 20 with a = 1 um, R_s = 62.5 um: the depth, then the force back.
        k, w, sphere = 4.2726925917809e10, 0.144, 62.5e-6
        scale_a = (math.pi * w * sphere**2 / k) ** (1 / 3)
        scale_d = (math.pi**2 * w**2 * sphere / k**2) ** (1 / 3)
        point = json.loads(self.done("contact", "--lambda", 20, "--radius", 1e-6 / scale_a,
                                     "--json").stdout)["rows"][0]
        row = json.loads(self.done(*FORCES, "--form", "corrected", "--set",
                                   "laws.adhesion.maugis_lambda=20", "--depth-nm",
                                   1e9 * scale_d * point["D"], "--json").stdout)["rows"][0]
        self.assertAlmostEqual(row["adhesion_uN"] / (1e6 * math.pi * w * sphere * point["P"]), 1,
                               delta=1e-7)
        self.refused(2, *FORCES, "--form", "corrected", "--set",
                     "laws.adhesion.maugis_lambda=101", says=["0.01 to 100"])
        self.refused(2, *FORCES, "--set", "laws.adhesion.maugis_lambda=20", says=["0.12 to 5.8"])

    def test_names_in_a_plot_run_nothing(self):
        scene = json.load(open(SOURCE + "/data/scenes/paper.json"))
        for quote in "'\"`":
            scene["name"] = f"x{quote}; system \"touch {self.path('reached')}\"; # `touch reached`"
            json.dump(scene, open(self.path("named.json"), "w"))
            self.done("forces", "--scene", self.path("named.json"), "--gap-nm", "1:9:9", "--plot",
                      self.path("p.svg"), cwd=self.folder)
            self.assertFalse(os.path.exists(self.path("reached")))

    def test_a_plot_follows_a_link_and_leaves_a_device_a_device(self):
        target, link = self.path("target.svg"), self.path("link.svg")
        open(target, "w").close()
        os.symlink(target, link)
        for file in (link, "/dev/null"):
            self.done(*FORCES, "--gap-nm", "1:9:9", "--plot", file)
        self.assertTrue(os.path.islink(link))
        self.assertIn("</svg>", open(target).read())
        self.assertFalse(os.path.isfile("/dev/null"))

    def test_bad_ranges(self):
        for text in ("", "a", "1:2", "1:2:0", "1:2:3:lin", "0:5:3:log", "-1", "1:2:2.5", "nan"):
            self.refused(2, *FORCES, "--gap-nm=" + text, says=["--gap-nm"])
        self.refused(2, *FORCES, "--gap-nm", "1e-300:1e300:5:log", says=["too far apart"])

    def test_of_a_recording_are_those_of_its_rows(self):
        file = self.record(self.path("episodes"), episodes=1)[0]
        document = json.loads(self.done("forces", file, "--json").stdout)
        with h5py.File(file) as f:
            demo = f["data/demo_0"]
            forces, names = demo["rows/forces"][:], demo["rows/forces"].attrs["columns"]
            times, holder = demo["rows/time"][:].ravel(), demo["rows/holder_wrench"][:, :3]
        names = [name.decode().removesuffix("_x") for name in names]
        self.assertEqual(document["rows"], len(times))
        self.assertAlmostEqual(document["felt_largest_uN"],
                               1e6 * numpy.linalg.norm(holder - holder[0], axis=1).max(), delta=1e-9)
        shares = 0
        for term in document["terms"]:
            at = names.index(term["term"])
            size = 1e6 * numpy.linalg.norm(forces[:, at:at + 3], axis=1)
            acts = size > 0
            self.assertAlmostEqual(term["share_of_time"], acts.mean(), delta=1e-12)
            self.assertAlmostEqual(term["largest_uN"], size.max(), delta=1e-9)
            self.assertAlmostEqual(term["median_uN"], numpy.median(size[acts]) if acts.any() else 0,
                                   delta=1e-9)
            self.assertEqual(term["first_s"], times[acts][0] if acts.any() else None)
            shares += term["share_of_felt"] or 0
        self.assertAlmostEqual(shares, 1, delta=0.01)
        table = self.done("forces", file).stdout
        self.assertIn("gravity", table)
        # What was changed of the scene, and not what was drawn of it.
        self.assertRegex(table.splitlines()[0], "^scene paper with limits.speed_um_s = .*, as recorded$")
        self.assertNotIn("start.y_um", table)
        csv = self.done("forces", file, "--csv").stdout.splitlines()
        self.assertEqual(len(csv), 1 + len(document["terms"]))
        self.done("forces", file, "--plot", self.path("plot.svg"))
        self.refused(2, "forces", file, "--gap-nm", 10, says=["--gap-nm"])
        self.refused(2, "forces", self.path("episodes"), says=["is a folder"])
        self.refused(3, "forces", self.path("none.h5"), says=["none.h5"])

    def test_release_states_every_path_and_what_holds(self):
        document = json.loads(self.done("release", "--scene", "bench", "--length-um", 80,
                                        "--json").stdout)
        self.assertEqual([row["path"] for row in document["rows"]], ["lift", "peel", "slide"])
        for row in document["rows"]:
            parts = [v for k, v in row.items() if k.endswith("_uN") and k != "force_uN"]
            self.assertAlmostEqual(row["force_uN"], sum(parts), delta=1e-9)
        work = math.pi * 0.02 * 62.5  # pi w R_s, uN
        self.assertAlmostEqual(document["jkr_uN"], 1.5 * work, delta=1e-6)
        self.assertAlmostEqual(document["dmt_uN"], 2 * work, delta=1e-6)
        self.assertGreater(document["pull_off_uN"], document["jkr_uN"])
        self.assertLess(document["pull_off_uN"], document["dmt_uN"])
        self.refused(2, "release", "--places", 3, says=["--places"])
        self.refused(2, "release", "--length-um", -1, says=["--length-um"])

    def test_limits_are_those_of_the_edge_of_the_scene(self):
        def ring(*more):
            told = json.loads(self.done("limits", "--scene", "bench", "--json", *more).stdout)
            return told["edge_um"], {row["damage"]: row["force_uN"] for row in told["rows"]}["ring"]
        self.assertEqual(ring()[0], 1)
        self.assertEqual(ring("--set", "fibre.edge_um=0.05"), ring("--edge-um", 0.05))
        self.assertEqual(ring("--set", "fibre.edge_um=0.05", "--edge-um", 2), ring("--edge-um", 2))
        self.assertLess(ring("--edge-um", 0.05)[1], 0.1 * ring()[1])
        rows = list(csv.DictReader(io.StringIO(self.done(
            "limits", "--scene", "bench", "--csv", "--edge-um", 2, "--stress-GPa", 1.4).stdout)))
        self.assertEqual([(float(row["edge_um"]), float(row["stress_GPa"])) for row in rows],
                         [(2, 1.4)] * 4)

    def first_damage(self, *more):
        rows = json.loads(self.done("limits", "--scene", "bench", "--json", *more).stdout)["rows"]
        return min(rows, key=lambda row: row["force_uN"] or math.inf)

    # The radius of an edge that the scene does not state may be that of a cleaved or of a polished end.
    def test_a_limit_that_lets_the_fibre_be_damaged_is_said(self):
        sharp, first = self.first_damage("--edge-um", 0.02), self.first_damage()
        self.assertLess(sharp["force_uN"], 0.1 * first["force_uN"])
        for force, said in ((1.01 * first["force_uN"], "is"), (0.99 * first["force_uN"], "may be"),
                            (1.01 * sharp["force_uN"], "may be"), (0.99 * sharp["force_uN"], "")):
            setting = ["--scene", "bench", *QUICK, "--set", f"limits.force_uN={force}"]
            note = f"note: limits.force_uN = {force:g}: the fibre {said} damaged before: {sharp['damage']} from "
            for arguments in (["evaluate", "--baseline", "constant-velocity", "--trials", 1],
                              ["record", "--episodes", 1, "--out", self.path("out"), "--append"]):
                run = self.done(*arguments, *setting, "--json")
                damage = json.loads(run.stdout)["damage"]
                self.assertEqual([damage["by"], damage["sharpest_by"]], [first["damage"], sharp["damage"]])
                self.assertEqual(damage["edge_um"], [0.02, 1])
                self.assertAlmostEqual(damage["over_limit"] * force, first["force_uN"], places=6)
                self.assertAlmostEqual(damage["sharpest_force_uN"], sharp["force_uN"], places=6)
                for text in (run.stderr, self.done(*arguments, *setting).stdout):
                    self.assertEqual(note in text, bool(said))
                    self.assertEqual("damaged before" in text, bool(said))
        self.assertIn("does not state fibre.edge_um", self.done("limits", "--scene", "bench").stdout)

    def test_a_stated_edge_is_no_range(self):
        edge = ["--set", "fibre.edge_um=0.05"]
        first = self.first_damage(*edge)
        run = self.done("evaluate", "--baseline", "constant-velocity", "--trials", 1, "--scene", "bench",
                        *QUICK, *edge, "--set", f"limits.force_uN={1.01 * first['force_uN']}", "--json")
        self.assertIn(f"is damaged before: {first['damage']} at {first['force_uN']:.4g} uN", run.stderr)
        self.assertEqual(json.loads(run.stdout)["damage"]["edge_um"], [0.05, 0.05])
        self.assertNotIn("does not state", self.done("limits", "--scene", "bench", *edge).stdout)

    def test_a_fibre_is_no_farther_in_than_the_bore_is_long(self):
        for verb in ("forces", "release"):
            self.refused(2, verb, "--scene", "bench", "--length-um", 10501,
                         says=["--length-um 10501", "10500 um", "ferrule.length_mm"])
        self.refused(2, "forces", "--length-um", "100:11000:3", says=["11000"])
        self.done("forces", "--scene", "bench", "--length-um", 10500)

    def test_what_two_recordings_feel_like_is_set_side_by_side(self):
        files = self.record(self.path("out"), "--append", episodes=2)
        told = json.loads(self.done("forces", files[0], "--against", files[1], "--json").stdout)
        against = told["against"]
        self.assertEqual(against["file"], files[1])
        self.assertGreater(against["places"], 10)
        self.assertLessEqual(against["places_touching"], against["places"])
        self.assertLessEqual(against["places_both_touch"], against["places_touching"])
        self.assertLessEqual(against["median_N"], against["largest_N"])
        itself = json.loads(self.done("forces", files[0], "--against", files[0], "--json").stdout)
        self.assertEqual(itself["against"]["share_noticed"], 0)
        self.assertEqual(itself["against"]["largest_N"], 0)
        self.assertIn("at the same place", self.done("forces", files[0], "--against", files[1]).stdout)
        self.refused(2, "forces", "--against", files[0], says=["--against"])
        self.refused(3, "forces", files[0], "--against", self.path("none.h5"), says=["none.h5"])


if __name__ == "__main__":
    main()
