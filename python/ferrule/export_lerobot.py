"""Demonstrations as a LeRobot dataset, version 3.0: meta/ and data/, in JSON and Parquet."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from . import BadInput
from .demonstrations import Demonstrations
from .task import OBSERVATION

TASK = "Insert the fibre into the ferrule."
_ACTION = ("x", "y", "z", "tilt_y", "tilt_z")
_QUANTILES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}
_CHUNK = {"chunk_index": 0, "file_index": 0}


def write(folder: str, found: Demonstrations) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    if found.rate != round(found.rate):
        raise BadInput(f"--rate {found.rate:g}: LeRobot takes whole numbers a second")
    root = Path(folder)
    columns = _columns(found)
    for sub in ("data/chunk-000", "meta/episodes/chunk-000"):
        (root / sub).mkdir(parents=True)
    fields: dict[str, Any] = {}
    for name, values in columns.items():
        if values.ndim == 2:
            flat = pa.array(values.ravel(), type=pa.float32())
            fields[name] = pa.FixedSizeListArray.from_arrays(flat, values.shape[1])
        else:
            fields[name] = pa.array(values)
    pq.write_table(pa.table(fields), root / "data/chunk-000/file-000.parquet")
    pq.write_table(_tasks(pa), root / "meta/tasks.parquet")
    pq.write_table(
        pa.Table.from_pylist(_episodes(columns)), root / "meta/episodes/chunk-000/file-000.parquet"
    )
    _write_json(root / "meta/stats.json", {n: _stats(v) for n, v in columns.items()})
    _write_json(root / "meta/info.json", _info(found, columns))


def _columns(found: Demonstrations) -> dict[str, np.ndarray]:
    lengths = [len(d.action) for d in found.demonstrations]
    frame = np.concatenate([np.arange(n) for n in lengths])
    done = np.concatenate([np.arange(n) == n - 1 for n in lengths])
    together = [("observation.state", "observation"), ("action", "action"), ("next.reward", "reward")]
    columns = {
        name: np.concatenate([getattr(d, field) for d in found.demonstrations]).astype(np.float32)
        for name, field in together
    }
    # What the fibre does to the hand once more: policies without cameras ask for it by this name.
    columns["observation.environment_state"] = columns["observation.state"][:, :5]
    columns["next.done"] = done
    columns["timestamp"] = (frame / found.rate).astype(np.float32)
    columns["frame_index"] = frame
    columns["episode_index"] = np.repeat(np.arange(len(lengths)), lengths)
    columns["index"] = np.arange(sum(lengths))
    columns["task_index"] = np.zeros(sum(lengths), dtype=np.int64)
    return columns


def _stats(values: np.ndarray) -> dict[str, list]:
    table = values.reshape(len(values), -1).astype(float)
    stats = {
        "min": table.min(axis=0), "max": table.max(axis=0),
        "mean": table.mean(axis=0), "std": table.std(axis=0),
    }
    stats.update({name: np.quantile(table, q, axis=0) for name, q in _QUANTILES.items()})
    return {**{name: s.tolist() for name, s in stats.items()}, "count": [len(values)]}


def _episodes(columns: dict[str, np.ndarray]) -> list[dict[str, Any]]:
    rows = []
    episodes = columns["episode_index"]
    for number in range(int(episodes[-1]) + 1):
        begin, end = np.searchsorted(episodes, [number, number + 1])
        row: dict[str, Any] = {"episode_index": number, "tasks": [TASK], "length": int(end - begin)}
        row.update({f"data/{key}": value for key, value in _CHUNK.items()})
        row.update(dataset_from_index=int(begin), dataset_to_index=int(end))
        for name, values in columns.items():
            stats = _stats(values[begin:end])
            row.update({f"stats/{name}/{key}": value for key, value in stats.items()})
        row.update({f"meta/episodes/{key}": value for key, value in _CHUNK.items()})
        rows.append(row)
    return rows


def _tasks(pa: Any) -> Any:
    """A table whose index in pandas is the text of the task."""
    table = pa.table({"task_index": pa.array([0]), "task": pa.array([TASK])})
    described = [
        {"name": name, "field_name": name, "pandas_type": kind, "numpy_type": held, "metadata": None}
        for name, kind, held in [("task_index", "int64", "int64"), ("task", "unicode", "object")]
    ]
    pandas = {"index_columns": ["task"], "column_indexes": [], "columns": described}
    return table.replace_schema_metadata({"pandas": json.dumps(pandas)})


def _info(found: Demonstrations, columns: dict[str, np.ndarray]) -> dict[str, Any]:
    names = {
        "observation.state": list(OBSERVATION),
        "observation.environment_state": list(OBSERVATION[:5]),
        "action": list(_ACTION),
    }
    features = {
        name: {
            "dtype": str(values.dtype),
            "shape": list(values.shape[1:]) or [1],
            "names": names.get(name),
        }
        for name, values in columns.items()
    }
    count = len(found.demonstrations)
    return {
        "codebase_version": "v3.0",
        "robot_type": "ferrule",
        "total_episodes": count,
        "total_frames": len(columns["index"]),
        "total_tasks": 1,
        "chunks_size": 1000,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": round(found.rate),
        "splits": {"train": f"0:{count}"},
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": None,
        "features": features,
        "environment": {"id": "ferrule/Insertion-v0", "kwargs": found.environment},
    }


def _write_json(file: Path, value: Any) -> None:
    file.write_text(json.dumps(value, indent=1) + "\n")
