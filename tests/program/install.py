import json
import os
import shutil
import subprocess

from case import BUILD, SOURCE, Case, main


class Install(Case):
    """Slow; only in the release build."""

    def test_the_simulator_alone_needs_no_package_but_eigen_and_json(self):
        prefix = self.path("prefix")
        subprocess.run(["cmake", "--install", BUILD, "--prefix", prefix], check=True,
                       stdout=subprocess.DEVNULL)
        shutil.copy(SOURCE + "/examples/01_step.cpp", self.path("step.cpp"))
        with open(self.path("CMakeLists.txt"), "w", encoding="utf8") as lists:
            lists.write("cmake_minimum_required(VERSION 3.25)\nproject(alone LANGUAGES CXX)\n"
                        "find_package(ferrule 0.9 REQUIRED COMPONENTS ${WANTED})\n"
                        "add_executable(step step.cpp)\n"
                        "target_link_libraries(step PRIVATE ferrule::sim)\n")
        others = ["Boost", "fmt", "TBB", "HDF5", "Ceres", "PkgConfig", "Torch", "SUNDIALS"]
        build = self.path("build")
        configure = ["cmake", "-S", self.path(""), "-B", build, "-DCMAKE_PREFIX_PATH=" + prefix,
                     *(f"-DCMAKE_DISABLE_FIND_PACKAGE_{other}=ON" for other in others)]
        subprocess.run([*configure, "-DWANTED=sim"], check=True, stdout=subprocess.DEVNULL)
        subprocess.run(["cmake", "--build", build], check=True, stdout=subprocess.DEVNULL)
        subprocess.run([build + "/step"], check=True, stdout=subprocess.DEVNULL)
        # The scenes are those of the installation, wherever the program lies.
        os.rename(prefix + "/share/ferrule/scenes/paper.json", self.path("paper.json"))
        lost = subprocess.run([build + "/step"], capture_output=True, text=True)
        self.assertNotEqual(lost.returncode, 0)
        refused = subprocess.run([*configure, "-DWANTED=learn"], capture_output=True, text=True)
        self.assertNotEqual(refused.returncode, 0)

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
