"""Episodes in the formats of others, read back by others."""

import csv as standard_csv
import json
import os
import shutil
import signal
import subprocess
import sys
import time

import gymnasium
import h5py
import numpy as np
import pytest

import ferrule
from conftest import PROGRAM, run
from ferrule import export_rows
from ferrule.demonstrations import episode_files

csv = pytest.importorskip("pyarrow.csv")
pq = pytest.importorskip("pyarrow.parquet")


@pytest.fixture(scope="module")
def robomimic(episodes):
    file = episodes.parent / "all.h5"
    run("export-episodes", episodes, "--robomimic", file, "--relative")
    return file


def test_robomimic_finds_what_it_needs(robomimic, episodes):
    with h5py.File(robomimic) as f:
        names = sorted(f["data"])
        assert len(names) == len(list(episodes.glob("*.h5")))
        assert f["data"].attrs["total"] == sum(f["data"][n].attrs["num_samples"] for n in names)
        environment = json.loads(f["data"].attrs["env_args"])
        assert environment["type"] == 2 and "/" not in environment["env_name"]
        masks = [name.decode() for mask in ("train", "valid") for name in f["mask"][mask]]
        assert sorted(masks) == names and len(f["mask/valid"]) == 1
        for name in names:
            demo, n = f["data"][name], f["data"][name].attrs["num_samples"]
            assert demo["actions"].shape == (n, 5) and np.abs(demo["actions"][:]).max() <= 1
            assert demo["obs/flat"].shape == demo["next_obs/flat"].shape == (n, 7)
            assert (demo["obs/flat"][1:] == demo["next_obs/flat"][:-1]).all()
            assert demo["dones"][:].tolist() == [0] * (n - 1) + [1]
            assert abs(demo["rewards"][:].sum() - 2) < 0.01
        peaks = np.max([np.abs(f["data"][n]["actions"][:]).max(axis=0) for n in names], axis=0)
        assert (peaks[:3] > 0.9).all()  # each column is of order one


def test_actions_are_the_mean_velocity_over_the_longer_period(robomimic, episodes):
    episode = ferrule.Episode(sorted(episodes.glob("*.h5"))[0])
    with h5py.File(robomimic) as f:
        demo = f["data/demo_0"]
        scale = demo["actions"].attrs["scale_m_s_rad_s"]
        motion = ferrule.load_scene(episode.scene).motion_scale
        tip = demo["actions"][:] * scale
        way = (episode.hand_pose[50:5001:50, :3] - episode.hand_pose[:-50:50, :3][:100]) / motion
        np.testing.assert_allclose(0.05 * tip[:100, :3], way, rtol=1e-6, atol=1e-12)
        assert (demo["obs/flat"][:, :5] == episode.relative_wrench[::50][: len(tip)].astype("f4")).all()
        np.testing.assert_allclose(demo["obs/flat"][:, 6], 0.05 * np.arange(len(tip)), rtol=1e-6)


def test_the_environment_it_names_takes_its_actions_to_success(robomimic, episodes):
    files = sorted(episodes.glob("*.h5"))
    with h5py.File(robomimic) as f:
        arguments = json.loads(f["data"].attrs["env_args"])["env_kwargs"]
        arguments.pop("seed")
        env = gymnasium.make("ferrule/Insertion-v0", **arguments).unwrapped
        for number, file in enumerate(files[:3]):
            episode, demo = ferrule.Episode(file), f[f"data/demo_{number}"]
            observation, _ = env.reset(seed=episode.seed, options={"trial": episode.trial})
            np.testing.assert_allclose(observation, demo["obs/flat"][0], atol=1e-6)
            for action in demo["actions"]:
                observation, _, terminated, _, info = env.step(action)
                if terminated:
                    break
            assert info.get("outcome", "inserted") == "inserted"
            assert info["inserted_length_m"] > 0.97 * env.task.scene.success_depth


def test_episodes_of_drawn_parts_are_of_the_scene_that_they_were_drawn_from(tmp_path):
    changes = {"sensor.entrance_sd_um": 8, "fibre.curl_radius_m": 2}
    folder, file = tmp_path / "drawn", tmp_path / "all.h5"
    settings = [word for key, value in changes.items() for word in ("--set", f"{key}={value}")]
    run("record", "--scene", "bench", *settings, "--episodes", 2, "--seed", 3, "--out", folder)
    run("export-episodes", folder, "--robomimic", file, "--relative")
    with h5py.File(file) as f:
        arguments = json.loads(f["data"].attrs["env_args"])["env_kwargs"]
        arguments.pop("seed")
        assert arguments["scene"] == json.loads(ferrule.load_scene("bench", changes).json)
        env = gymnasium.make("ferrule/Insertion-v0", **arguments).unwrapped
        for number, recorded in enumerate(sorted(folder.glob("*.h5"))):
            episode, demo = ferrule.Episode(recorded), f[f"data/demo_{number}"]
            env.reset(seed=episode.seed, options={"trial": episode.trial})
            assert "entrance_error_um" in episode.scene["sensor"]
            for action, row in zip(demo["actions"][:300], demo["next_obs/flat"][:300]):
                observation = env.step(action)[0]
                # The hand goes the same way, and knows its depth as well as the demonstrator did.
                np.testing.assert_allclose(observation[5], row[5], atol=1e-3)


def test_lerobot_finds_what_it_needs(episodes, robomimic):
    folder = episodes.parent / "lerobot"
    run("export-episodes", episodes, "--lerobot", folder, "--relative")
    info = json.loads((folder / "meta/info.json").read_text())
    data = pq.read_table(folder / "data/chunk-000/file-000.parquet")
    meta = pq.read_table(folder / "meta/episodes/chunk-000/file-000.parquet").to_pylist()
    assert info["codebase_version"] == "v3.0" and info["fps"] == 20
    assert info["total_frames"] == data.num_rows and info["total_episodes"] == len(meta)
    assert set(info["features"]) == set(data.column_names)
    with h5py.File(robomimic) as f:
        for row in meta:
            part = data.slice(row["dataset_from_index"], row["length"])
            actions = np.array(part["action"].to_pylist(), dtype="f4")
            demo = f[f"data/demo_{row['episode_index']}"]
            assert (actions == demo["actions"][:].astype("f4")).all()
            assert set(part["episode_index"].to_pylist()) == {row["episode_index"]}
    stats = json.loads((folder / "meta/stats.json").read_text())
    state = np.array(data["observation.state"].to_pylist())
    np.testing.assert_allclose(stats["observation.state"]["mean"], state.mean(axis=0), rtol=1e-4, atol=1e-6)


def test_csv_holds_every_bit(episodes):
    folder = episodes.parent / "csv"
    run("export-episodes", episodes, "--csv", folder)
    for file in sorted(episodes.glob("*.h5"))[:1]:
        episode = ferrule.Episode(file)
        table = csv.read_csv(folder / f"{file.stem}.csv")
        assert (table["force_friction_z_N"].to_numpy() == episode.force("friction")[:, 2]).all()
        assert (table["wrench_My_Nm"].to_numpy() == episode.wrench[:, 3]).all()
        assert (table["tip_tilt_y_rad"].to_numpy() == episode.states[:, 3]).all()
        assert (table["displacement_tilt_z_rad"].to_numpy() == episode.displacement[:, 4]).all()
        assert (table["height_m"].to_numpy() == episode.height).all()
        assert (table["depth_m"].to_numpy() == episode.depth).all()
        assert not any(table["phase"].to_pylist())


@pytest.fixture(scope="module")
def searched(tmp_path_factory):
    folder = tmp_path_factory.mktemp("searched") / "episodes"
    run("record", "--operator", "searching", "--scene", "by_hand/sharp", "--episodes", 1, "--out", folder)
    return folder


def test_where_the_hand_was_and_what_it_was_at_is_exported(searched, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)  # which a table of numbers does not need
    assert export_rows.write_csv(tmp_path, searched, 100) == 1
    with open(tmp_path / "episode_0001.csv", newline="") as table:
        rows = list(standard_csv.DictReader(table))
    episode = ferrule.Episode(searched / "episode_0001.h5")
    assert [row["phase"] for row in rows] == episode.phase[::10].tolist()
    assert [float(row["height_m"]) for row in rows] == episode.height[::10].tolist()
    assert len(set(episode.phase)) > 3 and len(episode.phase) == len(episode)
    for row, name in episode.phases:
        assert episode.phase[row] == name and (row == 0 or episode.phase[row - 1] != name)
    # As a controller observes it in the same trial.
    seen = ferrule.Simulator(episode.scene).reset(seed=episode.seed, trial=episode.trial)
    assert seen.height == pytest.approx(episode.height[0], rel=1e-12)
    np.testing.assert_allclose(episode.displacement, episode.hand_pose - episode.hand_pose[0], atol=0)
    np.testing.assert_array_equal(episode.depth, np.maximum(0, -episode.height))


def test_a_phase_that_a_spreadsheet_would_compute_is_a_text(searched, tmp_path):
    shutil.copytree(searched, tmp_path / "odd")
    hostile = ["=1+1", 'a,"b"', "+x", "M\u00fcller\n"]
    with h5py.File(tmp_path / "odd/episode_0001.h5", "r+") as file:
        file.attrs["phases"] = json.dumps([[10 * n, name] for n, name in enumerate(hostile)])
    assert export_rows.write_csv(tmp_path, tmp_path / "odd", 1000) == 1
    with open(tmp_path / "episode_0001.csv", newline="", encoding="utf-8") as table:
        rows = list(standard_csv.DictReader(table))
    assert [rows[10 * n]["phase"] for n in range(4)] == ["'=1+1", 'a,"b"', "'+x", "M\u00fcller\n"]


def test_episodes_are_in_the_order_of_their_numbers(searched, tmp_path):
    names = ["episode_0999.h5", "episode_9999.h5", "episode_10000.H5"]
    for name in names:
        shutil.copy(searched / "episode_0001.h5", tmp_path / name)
    for left in ("._episode_9999.h5", ".DS_Store", "Thumbs.db", "desktop.ini"):
        (tmp_path / left).write_bytes(b"\0\5\x16\7\0\2\0\0Mac OS X")
    assert [file.name for file in episode_files(tmp_path)] == names


def test_mcap_is_read_by_its_reader(episodes):
    reader = pytest.importorskip("mcap.reader")
    folder = episodes.parent / "mcap"
    run("export-episodes", episodes, "--mcap", folder, "--rate", 10)
    file = sorted(episodes.glob("*.h5"))[0]
    episode = ferrule.Episode(file)
    with open(folder / f"{file.stem}.mcap", "rb") as stream:
        messages = list(reader.make_reader(stream).iter_messages(topics=["/relative_wrench"]))
    assert len(messages) == len(episode.time[::100])
    schema, channel, message = messages[7]
    assert schema.encoding == "jsonschema" and channel.message_encoding == "json"
    assert message.log_time == 700_000_000
    assert json.loads(message.data)["Fy_N"] == episode.relative_wrench[700, 1]


def test_mcap_has_where_the_hand_was_and_what_it_was_at(searched, tmp_path):
    reader = pytest.importorskip("mcap.reader")
    assert export_rows.write_mcap(tmp_path, searched, 10) == 1
    episode = ferrule.Episode(searched / "episode_0001.h5")
    with open(tmp_path / "episode_0001.mcap", "rb") as stream:
        found = {"/height": [], "/phase": [], "/displacement": []}
        for _, channel, message in reader.make_reader(stream).iter_messages(topics=list(found)):
            found[channel.topic].append(json.loads(message.data))
    assert [each["name"] for each in found["/phase"]] == episode.phase[::100].tolist()
    assert [each["m"] for each in found["/height"]] == episode.height[::100].tolist()
    assert [each["z_m"] for each in found["/displacement"]] == episode.displacement[::100, 2].tolist()


def test_what_cannot_be_exported_is_said(episodes, tmp_path):
    said = run("export-episodes", episodes, "--robomimic", tmp_path / "x.h5", "--rate", 300, code=2)
    assert "--rate 300" in said.stderr and list(tmp_path.iterdir()) == []
    run("export-episodes", episodes, code=2)
    run("export-episodes", tmp_path / "nowhere", "--csv", tmp_path / "x", code=3)
    run("export-episodes", tmp_path, "--csv", tmp_path / "x", code=2)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").touch()
    run("export-episodes", episodes, "--lerobot", tmp_path / "full", code=3)
    said = run("export-episodes", episodes, "--csv", tmp_path / "full" / "file", code=3)
    assert said.stderr.endswith("file: is there, and no folder\n")
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "episode_0001.h5").write_bytes(b"no episode")
    said = run("export-episodes", tmp_path / "broken", "--robomimic", tmp_path / "x.h5", code=3)
    assert "not a readable HDF5 file" in said.stderr


def test_others_scenes_are_not_mixed(episodes, tmp_path):
    both = tmp_path / "both"
    run("record", "--scene", "demo", "--episodes", 1, "--out", both)
    for number, file in enumerate(sorted(episodes.glob("*.h5"))[:2], start=2):
        (both / f"episode_{number:04}.h5").write_bytes(file.read_bytes())
    said = run("export-episodes", both, "--robomimic", tmp_path / "x.h5", code=2)
    assert "another scene" in said.stderr


def begun(episodes, folder, name):
    """An export that has begun to write, and what it writes."""
    process = subprocess.Popen(
        [PROGRAM, "export-episodes", episodes, "--csv", folder / name],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )
    beside = folder / f".{name}.{process.pid}"
    while not beside.is_dir():
        assert process.poll() is None, process.communicate()
        time.sleep(0.001)
    return process, beside


def test_a_killed_export_leaves_nothing_that_the_next_one_does_not_clear(episodes, tmp_path):
    process, beside = begun(episodes, tmp_path, "tables")
    process.kill()
    process.communicate()
    assert beside.is_dir()
    others = [f".tables.{os.getpid()}", ".tables.01", ".tables.12x", ".other.1234567", "tables.1234567"]
    for name in others:
        (tmp_path / name).mkdir()
    run("export-episodes", episodes, "--csv", tmp_path / "tables")
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted([*others, "tables"])


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM])
def test_a_stopped_export_leaves_nothing(episodes, tmp_path, ending):
    process, _ = begun(episodes, tmp_path, "tables")
    process.send_signal(ending)
    said = process.communicate(timeout=60)[1]
    assert process.returncode == 130
    assert said.startswith("ferrule: stopped by ") and said.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_names_are_escaped_where_they_are_shown(episodes, tmp_path):
    odd = tmp_path / "red \x1b[31m\nline"
    said = run("export-episodes", episodes, "--csv", odd).stdout
    assert said == f"wrote {tmp_path}/red \\x1b[31m\\nline\n"
    said = run("export-episodes", tmp_path / "none" / odd.name, "--csv", tmp_path / "x", code=3).stderr
    assert said.count("\n") == 1 and "\x1b" not in said
    said = run("export-episodes", episodes, "--csv", odd, code=3).stderr
    assert said.count("\n") == 1 and "\x1b" not in said
