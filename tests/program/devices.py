import glob
import json
import os
import pty
import shutil
import signal
import subprocess
import termios
import time
import unittest

import h5py
import numpy

from case import PROGRAM, SOURCE, Case, ferrule, main


class Devices(Case):
    def test_a_machine_without_devices_says_so(self):
        # Where there are some, they are listed; both are fine.
        document = json.loads(self.done("devices", "--json").stdout)
        for device in document["devices"]:
            self.assertIn(device["state"], ("usable", "unusable", "forbidden", "never used"))
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
        # could be opened, the third is a mouse of the same maker, the fourth has three axes.
        six = "05010908A101850116A2FE265E01" "093009310932093309340935" "751095068102C0"
        three = "05010908A101850116A2FE265E01" "093009310932" "751095038102C0"
        text = ""
        for number, product in enumerate((0xC635, 0xC62E, 0xC650, 0x1234)):
            descriptor = three if number == 3 else six
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

        usable, forbidden, never, unusable = json.loads(listed("--json"))["devices"]
        self.assertEqual((usable["path"], usable["id"], usable["kind"], usable["state"]),
                         ("/dev/hidraw0", "256f:c635", "SpaceMouse", "usable"))
        self.assertEqual(usable["name"], "mouse 0")
        self.assertNotIn("udev_rule", usable)
        self.assertEqual(forbidden["state"], "forbidden")
        rule = 'KERNEL=="hidraw*", KERNELS=="*:256F:C62E.*", TAG+="uaccess"'
        self.assertEqual(forbidden["udev_rule"], rule)
        self.assertIn(rule, forbidden["command"])
        self.assertEqual((never["kind"], never["state"]), (None, "never used"))
        self.assertEqual((unusable["kind"], unusable["state"]), ("SpaceMouse", "unusable"))
        self.assertIn("no six axes", unusable["reason"])
        text = listed()
        self.assertIn("cannot be used: its report descriptor names no six axes", text)
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

    def test_a_reader_that_goes_away_ends_the_test_of_a_device(self):
        run = subprocess.Popen([PROGRAM, "devices", "--test", "fake:pid"], stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True)
        self.assertIn("fake:pid", run.stdout.readline())
        run.stdout.close()
        self.assertEqual(run.wait(timeout=60), 141)
        self.assertEqual(run.stderr.read(), "")
        run.stderr.close()

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
            self.done("record", "--scene", "demo", "--set", "start.distance_um=8", "--set",
                      "success.depth_um=5", "--device", device, "--episodes", 2, "--out", out)
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
                    loop = json.loads(f.attrs["loop"])
                    self.assertEqual(loop["period_us"], 1000)
                    self.assertEqual(loop["periods"], counts.shape[0] + 1)
                    times = [loop[k] for k in ("p50_us", "p99_us", "p99_9_us", "worst_us")]
                    self.assertEqual(times, sorted(times))
                    self.assertNotIn("coupling", f.attrs)
                    self.assertNotIn("rating", f.attrs)
                self.done("replay", file, "--verify")

    def test_a_scene_that_is_not_stable_is_refused_for_force_feedback(self):
        out = self.path("out")
        record = ["record", "--scene", "bench", "--episodes", 1, "--out", out, "--device"]
        self.refused(2, *record, "fake:pid", says=["bench on pen: refused", "N/m", "damping",
                                                   "--set scaling.hand_force_N=", "--coupled"])
        self.assertFalse(os.path.exists(out))
        # The scaling that it names is stable.
        told = ferrule(*record, "fake:pid").stderr.split("--set ")[1].split(". ")[0]
        short = ["--set", "start.distance_um=5", "--set", "success.depth_um=3",
                 "--set", "start.lateral_sd_um=0", "--set", "start.tilt_sd_mrad=0"]
        self.done(*record, "fake:pid", "--set", told, *short)
        for more in (["fake:spacemouse"], ["fake:pid", "--coupled"]):
            self.refused(2, *record, *more, *short, "--append", says=["another scaling"])
        record[6] = out = self.path("another")
        self.done(*record, "fake:spacemouse", *short)  # no force, nothing to refuse
        self.done(*record, "fake:pid", "--coupled", *short, "--append")
        with h5py.File(out + "/episode_0002.h5") as f:
            coupling = json.loads(f.attrs["coupling"])
            self.assertAlmostEqual(coupling["stiffness_N_m"], 2000)
        self.done("replay", out + "/episode_0002.h5", "--verify")
        for option in (["--coupled"], ["--profile", "pen"]):
            self.refused(2, *record, "fake:spacemouse", *option, says=[option[0], "force"])
        # A grip that moves the hand further feels a stiffer fibre: 1.69 kN/m of 2.67 that are stable.
        further = ["record", "--scene", "demo", "--device", "fake:pid", "--episodes", 1, *short,
                   "--out", self.path("further")]
        self.refused(2, *further, "--gain", 1.7, says=["demo on pen with --gain 1.7: refused"])
        self.done(*further, "--gain", 1.5)
        self.done(*further, "--gain", 4, "--coupled", "--append")
        with h5py.File(self.path("further") + "/episode_0002.h5") as f:
            self.assertAlmostEqual(json.loads(f.attrs["coupling"])["stiffness_N_m"], 500)
        pen = json.load(open(SOURCE + "/data/devices/pen.json"))
        with open(self.path("ice.json"), "w") as file:
            json.dump({**pen, "coulomb_N": 0}, file)
        self.refused(2, *record, "fake:pid", "--coupled", "--profile", self.path("ice.json"),
                     says=["no coupling is stable", "friction"])
        self.refused(3, *record, "fake:pid", "--profile", "nothing", says=["nothing", "pen"])

    def at_terminal(self, keys, *arguments):
        """Runs the program at a terminal; presses a key whenever its text appears next."""
        process, terminal = pty.fork()
        if process == 0:
            os.execv(PROGRAM, [PROGRAM, *map(str, arguments)])
        seen, self.shown, keys = "", "", list(keys)
        before = termios.tcgetattr(terminal)[:4]
        while True:
            try:
                part = os.read(terminal, 4096).decode(errors="replace")
            except OSError:  # it has ended
                break
            if not part:
                break
            seen += part
            self.shown += part
            while keys and keys[0][0] in seen:
                text, key = keys.pop(0)
                seen = seen[seen.index(text) + len(text):]
                time.sleep(0.3)
                os.write(terminal, key.encode())
        code = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
        self.assertEqual(termios.tcgetattr(terminal)[:4], before)
        os.close(terminal)
        self.assertEqual(keys, [])
        self.rest = seen
        return code

    def test_keys_start_end_discard_and_rate_an_episode(self):
        out = self.path("out")
        code = self.at_terminal(
            [("space starts", "x"), ("", " "), ("space ends it", " "), ("1 (poor)", "4"),
             ("space starts", " "), ("d discards it", "d"),
             ("space starts", " "), ("space ends it", " "), ("1 (poor)", "d"),
             ("space starts", " "), ("space ends it", " "), ("1 (poor)", " "),
             ("space starts", "q")],
            "record", "--scene", "demo", "--device", "fake:pid", "--episodes", 9, "--out", out)
        self.assertEqual(code, 0)
        self.assertIn("0 of 2 episodes inserted", self.rest)  # the discarded ones are no failures
        self.assertIn("beside", self.shown)  # the bore, where the gap would be negative
        self.assertNotRegex(self.shown, r"\b(gap|beside) +-")
        files = sorted(os.listdir(out))
        self.assertEqual(files, ["episode_0001.h5", "episode_0002.h5"])  # discarded ones again
        with h5py.File(out + "/episode_0001.h5") as f:
            self.assertEqual(f.attrs["rating"], 4)
            self.assertEqual(f.attrs["outcome"], b"stopped_short")
            self.assertGreater(f["data/demo_0"].attrs["num_samples"], 100)
        with h5py.File(out + "/episode_0002.h5") as f:
            self.assertNotIn("rating", f.attrs)
        for file in files:
            self.done("replay", out + "/" + file, "--verify")

    def test_a_person_stops_at_the_goal_or_goes_on(self):
        rows = {}
        for option in ([], ["--go-on-after-goal"]):
            out = self.path("out" + "".join(option))
            self.done("record", "--scene", "demo", "--set", "start.distance_um=8", "--set",
                      "success.depth_um=5", "--device", "fake:spacemouse", "--episodes", 1,
                      "--out", out, *option)
            with h5py.File(out + "/episode_0001.h5") as f:
                self.assertEqual(f.attrs["outcome"], b"inserted")
                rows[bool(option)] = -1e6 * f["data/demo_0/states"][:, 0]
            self.done("replay", out, "--verify")
        deep = numpy.flatnonzero(rows[False] >= 5)
        self.assertEqual(list(deep), [len(rows[False]) - 1])
        self.assertGreater(len(rows[True]), len(rows[False]))
        self.refused(2, "record", "--go-on-after-goal", "--out", self.path("none"),
                     says=["--go-on-after-goal", "--device"])

    def test_the_recording_ends_before_it_began(self):
        for key in ("\x03", "q"):
            code = self.at_terminal([("space starts", key)], "record", "--scene", "demo",
                                    "--device", "fake:pid", "--out", self.path(key))
            self.assertEqual(code, 130 if key == "\x03" else 0)
            self.assertEqual(os.listdir(self.path(key)), [])

    def test_q_ends_the_recording_with_the_episode(self):
        begin = ("space starts", " ")
        for n, keys in enumerate(([begin, ("space ends it", "q"), ("1 (poor)", "3")],
                                  [begin, ("space ends it", " "), ("1 (poor)", "q")],
                                  [begin, ("space ends it", "q"), ("1 (poor)", "d")])):
            out = self.path(str(n))
            code = self.at_terminal(keys, "record", "--scene", "demo", "--device", "fake:pid",
                                    "--out", out)
            self.assertEqual(code, 0)
            self.assertEqual(os.listdir(out), ["episode_0001.h5"] if n < 2 else [])

    def test_a_second_ctrl_c_ends_it_at_once_and_leaves_the_terminal(self):
        code = self.at_terminal([("space starts", " "), ("space ends it", "\x03\x03")], "record",
                                "--scene", "demo", "--device", "fake:pid", "--out",
                                self.path("out"))
        self.assertEqual(code, 130)

    def test_a_simulated_operator_leaves_neither(self):
        with h5py.File(self.record(self.path("out"), episodes=1)[0]) as f:
            self.assertNotIn("mapping", f.attrs)
            self.assertNotIn("loop", f.attrs)
            self.assertNotIn("raw", f["data/demo_0"])

    def test_gain_moves_the_hand_further(self):
        reach = {}
        for gain in (1, 2):
            out = self.path(str(gain))
            self.done("record", "--scene", "demo", "--set", "start.distance_um=8", "--set",
                      "success.depth_um=5", "--device", "fake:spacemouse", "--gain", gain,
                      "--episodes", 1, "--out", out)
            with h5py.File(out + "/episode_0001.h5") as f:
                reach[gain] = json.loads(f.attrs["mapping"])["gain_m_s"][0][0]
        self.assertAlmostEqual(reach[2] / reach[1], 2)

    def test_usage(self):
        out = ["--out", self.path("out")]
        self.refused(2, "record", "--device", "fake:pid", "--operator", "simulated", *out,
                     says=["--device", "--operator"])
        for device in ("fake:pid", "auto"):
            self.refused(2, "record", "--device", device, "--skill", 0.5, *out,
                         says=["--device", "--skill"])
        self.refused(2, "record", "--device", "fake:else", *out, says=["fake:spacemouse"])
        self.refused(2, "record", "--device", "fake:pid", "--gain", 0, *out, says=["--gain"])
        for option in (["--gain", 2], ["--coupled"], ["--profile", "pen"]):
            self.refused(2, "record", *option, *out, says=[option[0], "--device"])
        self.assertIn(ferrule("record", "--device", "", *out).returncode, (2, 4))
        self.refused(2, "devices", "--test", "fake:else", says=["fake:spacemouse"])
        self.refused(2, "devices", "--seconds", 1, says=["--test"])


if __name__ == "__main__":
    main()
