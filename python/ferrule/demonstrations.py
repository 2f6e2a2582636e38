"""The inserted episodes of a folder, at the rate of somebody who learns from them."""

from __future__ import annotations

import hashlib
import json
import math
import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Mapping

import numpy as np

from . import BadInput, Episode, FileTrouble, _core, load_scene
from .task import INSERTED, Task


@dataclass(frozen=True)
class Demonstration:
    """One insertion, row by row of the export."""

    file: str
    time_s: np.ndarray  # (N,)
    observation: np.ndarray  # (N, 7), as the environment's
    next_observation: np.ndarray  # the same one row later
    action: np.ndarray  # (N, 5) within [-1, 1]
    reward: np.ndarray  # (N,), as the environment's


@dataclass(frozen=True)
class Demonstrations:
    """All of a folder, and the environment that they are demonstrations in."""

    demonstrations: list[Demonstration]
    environment: dict[str, Any]  # arguments of ferrule/Insertion-v0
    rate: float  # rows a second
    left_out: int  # episodes that were not inserted
    cut: float  # share of the rows whose action was beyond 1


def episode_files(folder: str | os.PathLike) -> list[Path]:
    """In the order of their numbers. Raises FileTrouble where there is no such folder, BadInput where it has none."""
    if not Path(folder).is_dir():
        raise FileTrouble(f"{folder}: no such folder")
    files = _core._episode_files(folder)
    if not files:
        raise BadInput(f"{folder}: holds no episode (*.h5)")
    return files


class Copies:
    """Which of several episodes have the same rows: who counts episodes counts each once."""

    def __init__(self) -> None:
        self._files: dict[bytes, str] = {}

    def seen(self, episode: Episode, file: str | os.PathLike) -> bool:
        """Whether it is one of an episode before; says so on stderr."""
        rows = hashlib.sha1()
        for part in (episode.hand_pose, episode.command, episode.holder_wrench):
            rows.update(np.ascontiguousarray(part).tobytes())
        original = self._files.setdefault(rows.digest(), str(file))
        if original == str(file):
            return False
        note = f"note: {file} is left out: it has the rows of {original}, a copy"
        print(printable(note), file=sys.stderr)
        return True


def printable(text: object) -> str:
    """In one line, with what a terminal would act on escaped."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in str(text))


def _up_to_success(episode: Episode, depth: float) -> int:
    """Rows until the success depth is reached: the environment ends there, a recording goes on."""
    deep = np.flatnonzero(episode.states[:, 0] <= -depth)
    return int(deep[0]) if deep.size else len(episode)


def _sparse(episode: Episode, rows: int, periods: int) -> tuple[np.ndarray, np.ndarray]:
    """The rows that are kept, and the mean command over the time that each stands for [SI]."""
    first = np.arange(0, rows, periods)
    sums = np.add.reduceat(episode.command[:rows], first, axis=0)
    counts = np.diff(np.append(first, rows))
    return first, sums / counts[:, None]


def _scale(commands: list[np.ndarray], motion: float) -> list[float]:
    """Of actions: the largest mean velocity at the tip in each column, rounded up to 2 digits."""
    largest = np.max([np.abs(c).max(axis=0) for c in commands], axis=0)
    largest[:3] /= motion
    scale = []
    for column, most in enumerate(largest):
        if most == 0:  # nobody moved that way: what the environment takes unless told otherwise
            most = 1e-3 if column > 2 else float(max(largest[:3]))
        unit = 10.0 ** (math.floor(math.log10(most)) - 1)
        scale.append(float(f"{math.ceil(most / unit - 1e-9) * unit:.3g}"))
    return scale


def load_demonstrations(
    folder: str | os.PathLike,
    rate: float,
    relative: bool,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> Demonstrations:
    """Those of the inserted episodes, up to success. Raises BadInput, FileTrouble."""
    files = episode_files(folder)
    scene: dict[str, Any] | None = None
    kept, left_out, copies = [], 0, Copies()
    for number, file in enumerate(files):
        progress(number, len(files))
        episode = Episode(file)
        if copies.seen(episode, file):
            continue
        if episode.outcome != "inserted":
            left_out += 1
            continue
        document = json.loads(episode.undrawn_scene_json)
        if scene is not None and document != scene:
            raise BadInput(f"{file}: recorded in another scene than those before: export them apart")
        scene = document
        periods = 1 / (rate * episode.period) if rate > 0 else 0
        if round(periods) < 1 or abs(periods - round(periods)) > 1e-6 * periods:
            raise BadInput(
                f"--rate {rate:g}: {1 / episode.period:g} rows a second, as recorded, must be a "
                "whole multiple of it"
            )
        rows = _up_to_success(episode, load_scene_depth(document))
        first, command = _sparse(episode, rows, round(periods))
        wrench = episode.relative_wrench if relative else episode.wrench
        last = min(rows, len(episode) - 1)
        at = np.append(first, last)
        values = np.column_stack(
            [wrench[at], episode.depth[at], episode.time[at]]
        )
        kept.append((file, episode.time[first].copy(), values, command, episode.states[at, 0].copy()))
    progress(len(files), len(files))
    if scene is None:
        raise BadInput(f"{folder}: holds no inserted episode")
    return _built(kept, scene, rate, relative, left_out)


def load_scene_depth(document: Mapping[str, Any]) -> float:
    return 1e-6 * float(document["success"]["depth_um"])


def _built(
    kept: list[tuple], scene: dict[str, Any], rate: float, relative: bool, left_out: int
) -> Demonstrations:
    motion = load_scene(scene).motion_scale
    environment = {
        "scene": scene,
        "control_hz": rate,
        "action_scale": _scale([command for _, _, _, command, _ in kept], motion),
        "relative": relative,
    }
    task = Task(**environment)
    demonstrations, cut, rows = [], 0, 0
    for file, time, values, command, tip_x in kept:
        action = command / task.hand_scale
        cut += int((np.abs(action) > 1).any(axis=1).sum())
        rows += len(action)
        observed = task.observation(values, values[:, :5])
        outcome = np.full(len(action), -1)
        outcome[-1] = INSERTED
        demonstrations.append(
            Demonstration(
                str(file), time, observed[:-1], observed[1:], np.clip(action, -1, 1),
                task.reward(tip_x[:-1], tip_x[1:], outcome),
            )
        )
    return Demonstrations(demonstrations, environment, rate, left_out, cut / rows)
