import glob
import json
import os
import shutil
import signal
import subprocess
import time
import unittest

import h5py
import numpy

from case import PROGRAM, Case, main


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


if __name__ == "__main__":
    main()
