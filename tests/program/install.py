import json
import shutil
import subprocess

from case import BUILD, SOURCE, Case, main


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
    main()
