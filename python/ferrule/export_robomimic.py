"""Demonstrations as one HDF5 file of robomimic."""

from __future__ import annotations

import json

import numpy as np

from . import __version__
from .demonstrations import Demonstrations
from .task import OBSERVATION

#: What robomimic's EnvGym makes: ferrule/Insertion-v0 behind the interface of Gym that it knows. No
#: slash: robomimic names files after it.
ENVIRONMENT = "ferrule.robomimic_env:Insertion-v0"
GYM_TYPE = 2
SEED = 1_000_000_007  # of rollouts: none starts where a demonstration did


def validation(count: int) -> list[bool]:
    """Which of so many demonstrations validate: every tenth, one at least of two or more."""
    chosen = [number % 10 == 9 for number in range(count)]
    if count > 1 and not any(chosen):
        chosen[-1] = True
    return chosen


def write(file: str, found: Demonstrations) -> None:
    import h5py

    environment = {
        "env_name": ENVIRONMENT,
        "gymnasium_id": "ferrule/Insertion-v0",
        "type": GYM_TYPE,
        "env_type": GYM_TYPE,
        "env_version": __version__,
        "env_kwargs": {**found.environment, "seed": SEED},
    }
    names = [f"demo_{number}" for number in range(len(found.demonstrations))]
    with h5py.File(file, "w") as out:
        data = out.create_group("data")
        data.attrs["total"] = sum(len(d.action) for d in found.demonstrations)
        data.attrs["env_args"] = json.dumps(environment)
        data.attrs["rate_hz"] = found.rate
        for name, d in zip(names, found.demonstrations):
            demo = data.create_group(name)
            demo.attrs["num_samples"] = len(d.action)
            demo.attrs["file"] = d.file
            dones = np.zeros(len(d.action), dtype=np.int64)
            dones[-1] = 1
            for path, values in [
                ("actions", d.action),
                ("rewards", d.reward),
                ("dones", dones),
                ("obs/flat", d.observation),
                ("next_obs/flat", d.next_observation),
            ]:
                demo.create_dataset(path, data=values, compression="gzip", shuffle=True)
            demo["actions"].attrs["scale_m_s_rad_s"] = found.environment["action_scale"]
            demo["obs/flat"].attrs["columns"] = OBSERVATION
        validates = validation(len(names))
        for mask, wanted in [("train", False), ("valid", True)]:
            chosen = [n for n, v in zip(names, validates) if v == wanted]
            if chosen:
                out[f"mask/{mask}"] = np.array(chosen, dtype="S")
