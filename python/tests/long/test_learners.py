"""Others' own readers and trainers, unmodified, on what is exported and in the environment."""

import json
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from conftest import ROOT, run

EXAMPLES = ROOT / "examples/learners"


def python(*arguments, **options) -> str:
    done = subprocess.run([sys.executable, *map(str, arguments)], capture_output=True, text=True, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def robomimic_file(episodes) -> Path:
    file = episodes.parent / "all.h5"
    run("export-episodes", episodes, "--robomimic", file, "--relative")
    return file


@pytest.fixture(scope="module")
def lerobot_folder(episodes) -> Path:
    folder = episodes.parent / "dataset"
    run("export-episodes", episodes, "--lerobot", folder, "--relative")
    return folder


def evaluated(script: str, model: Path) -> dict:
    command = f"{sys.executable} {EXAMPLES / script} answer {model}"
    said = run("evaluate", "--scene", "bench", "--policy", command, "--policy-hz", 20,
               "--policy-timeout", 60, "--trials", 2, "--json")
    assert "note:" not in said.stderr, said.stderr
    return json.loads(said.stdout)


def test_robomimic_tells_what_is_in_the_file(robomimic_file, episodes):
    said = python("-m", "robomimic.scripts.get_dataset_info", "--dataset", robomimic_file)
    assert f"total trajectories: {len(list(episodes.glob('*.h5')))}" in said
    assert "Insertion-v0" in said and "valid" in said


def test_robomimic_reads_sequences(robomimic_file):
    python("-c", """if True:
        import sys
        import robomimic.utils.obs_utils as O
        from robomimic.utils.dataset import SequenceDataset
        O.initialize_obs_utils_with_obs_specs({"obs": {"low_dim": ["flat"], "rgb": []}})
        data = SequenceDataset(
            sys.argv[1], ("flat",), ("actions", "rewards", "dones"), seq_length=10,
            filter_by_attribute="train")
        item = data[5]
        assert item["obs"]["flat"].shape == (10, 7) and item["actions"].shape == (10, 5)
    """, robomimic_file)


def test_robomimic_trains_with_validation_and_rollouts_here(robomimic_file, tmp_path):
    script = EXAMPLES / "robomimic_bc_rnn.py"
    said = python(script, "train", robomimic_file, tmp_path / "model", "--epochs", 2, "--rollouts", 1)
    assert "trained in" in said
    assert "Validation Epoch 2" in said and "Success_Rate" in said and "traceback" not in said.lower()
    assert evaluated("robomimic_bc_rnn.py", tmp_path / "model")["trials"] == 2


def test_lerobot_reads_the_folder(lerobot_folder, episodes):
    from lerobot.datasets.lerobot_dataset import LeRobotDataset

    data = LeRobotDataset("ferrule/insertion", root=lerobot_folder)
    assert data.num_episodes == len(list(episodes.glob("*.h5")))
    item = data[3]
    assert item["action"].shape == (5,) and item["observation.state"].shape == (7,)
    assert item["task"] == "Insert the fibre into the ferrule."
    assert data.meta.stats["action"]["mean"].shape == (5,)


def test_act_of_lerobot_trains_on_it(lerobot_folder, tmp_path):
    model = tmp_path / "act"
    said = python(EXAMPLES / "lerobot_act.py", "train", lerobot_folder, model, "--steps", 30)
    assert "trained in" in said
    assert evaluated("lerobot_act.py", model)["trials"] == 2


def test_stable_baselines_finds_nothing_wrong():
    import gymnasium
    from stable_baselines3.common.env_checker import check_env

    import ferrule  # noqa: F401

    check_env(gymnasium.make("ferrule/Insertion-v0", scene="bench"), warn=True)


@pytest.mark.parametrize("how", ["fork", "spawn"])
def test_environments_run_in_processes_of_their_own(how):
    # A process that is spawned imports the package for the name before the colon.
    python("-c", """if True:
        import sys
        if __name__ == "__main__":
            import numpy as np
            from stable_baselines3.common.env_util import make_vec_env
            from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv
            arguments = dict(n_envs=2, seed=3, env_kwargs={"scene": "bench"})
            apart = make_vec_env("ferrule:ferrule/Insertion-v0", vec_env_cls=SubprocVecEnv,
                                 vec_env_kwargs={"start_method": sys.argv[1]}, **arguments)
            here = make_vec_env("ferrule:ferrule/Insertion-v0", vec_env_cls=DummyVecEnv, **arguments)
            assert (apart.reset() == here.reset()).all()
            for _ in range(20):
                actions = np.full((2, 5), -0.5)
                assert (apart.step(actions)[0] == here.step(actions)[0]).all()
            apart.close()
    """, how)


def test_ppo_learns_more_than_to_push_straight_in():
    said = python(EXAMPLES / "sb3_ppo.py", "--trials", 50)
    assert "inserted of 50 trials" in said


def test_xarray_knows_the_dimensions_by_name(episodes):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    file = sorted(episodes.glob("*.h5"))[0]
    with h5py.File(file) as f, xarray.open_dataset(
        file, engine="h5netcdf", group="/data/demo_0/rows", decode_times=False
    ) as rows:
        assert (rows["forces"].values == f["data/demo_0/rows/forces"][:]).all()
        assert rows["forces"].attrs["units"] == "N"
        assert np.isfinite(rows["forces"].values).all()
