import glob
import json


from case import SOURCE, Case, ferrule, main


class Doctor(Case):
    def setUp(self):
        super().setUp()
        self.validator = self.schema_validator("devices/device.schema.json")
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

    def test_it_looks_at_no_more_states_where_a_force_limit_is_far(self):
        d = self.doctor(0, "--scene", "film", "--set", "limits.force_uN=1e10")
        self.assertLess(d["tip"]["states"], 100000)

    def test_text_says_refused_and_why(self):
        run = ferrule("doctor", "--scene", "bench", "--seconds", 0.02)
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertIn("REFUSED for force feedback", run.stdout)
        self.assertIn("--set scaling.hand_force_N=", run.stdout)
        run = self.done("doctor", "--scene", "demo", "--seconds", 0.02)
        self.assertIn("STABLE", run.stdout)

    def test_with_a_gain_it_answers_as_record_does(self):
        short = ["--set", "start.distance_um=5", "--set", "success.depth_um=3"]
        once = self.doctor(0, "--scene", "demo", *short)
        for gain, code in ((1.5, 0), (1.7, 1)):
            d = self.doctor(code, "--scene", "demo", "--gain", gain, *short)
            self.assertEqual(d["gain"], gain)
            self.assertAlmostEqual(d["bounds"]["device_damping_N_s_m"] * gain,
                                   once["bounds"]["device_damping_N_s_m"])
            out = self.path(str(gain))
            run = ferrule("record", "--scene", "demo", "--device", "fake:pid", "--gain", gain,
                          "--episodes", 1, "--out", out, *short)
            self.assertEqual(run.returncode, 2 * code, run.stderr)
        run = ferrule("doctor", "--gain", 1.7, "--seconds", 0.02, *short)
        self.assertIn("pen with --gain 1.7", run.stdout)
        self.refused(2, "doctor", "--gain", 0, says=["--gain"])

    def test_it_takes_a_profile_and_no_device(self):
        for device in ("auto", "fake:pid", "/dev/hidraw0"):
            self.refused(2, "doctor", "--device", device, says=[device, "profile", "pen"])

    def test_schema_and_program_agree_on_profiles(self):
        for file in glob.glob(SOURCE + "/data/devices/*.json"):
            if not file.endswith(".schema.json"):
                self.validator.validate(json.load(open(file)))
        for key in self.pen:
            for value in (-1, "text", None, True) if key != "rate_Hz" else (9, 1e6):
                file = self.device(**{key: value})
                if self.validator.is_valid(json.load(open(file))):
                    continue
                self.refused(2, "doctor", "--device", file, says=[f"{file}: line 1: {key} = "])
        for key in ("damping_N_s_m", "coulomb_N", "resolution_um", "delay_periods"):
            file = self.device(**{key: 0})
            self.validator.validate(json.load(open(file)))
            run = ferrule("doctor", "--seconds", 0.01, "--device", file)
            self.assertIn(run.returncode, (0, 1), run.stderr)
        self.refused(2, "doctor", "--device", self.device(surprise=1), says=["unknown key"])
        self.refused(3, "doctor", "--device", "nothing", says=["nothing", "pen"])
        self.refused(2, "doctor", "--seconds", "0", says=["--seconds"])


if __name__ == "__main__":
    main()
