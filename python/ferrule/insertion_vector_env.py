"""Many fibres at once: gymnasium.make_vec("ferrule/Insertion-v0", num_envs=N)."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import ClosedEnvironmentError, ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from . import _MOST_THREADS, SceneLike, _core, _whole, outcomes
from .task import INSERTED, TIMEOUT, Task, checked_options, trial_number

_COLUMN = {name: i for i, name in enumerate(_core._trial_columns)}
_TIP = slice(_COLUMN["tip_x"], _COLUMN["tip_tilt_z"] + 1)
_MOTION = slice(_COLUMN["displacement_x"], _COLUMN["height"] + 1)


class InsertionVectorEnv(VectorEnv):
    """N environments as InsertionEnv, stepped in C++ on all cores.

    Further arguments: ``num_envs``; ``threads``, 0 for all cores. An environment whose episode has
    ended begins the next one in the step after that, whatever its action
    (AutoresetMode.NEXT_STEP).

    ``reset(seed=N)``: under one seed, environment i begins with trial i and goes on with trial i + N,
    i + 2 N ...: all of them together take the trials that one environment takes after one another.
    ``reset(seed=[...])``, one for each (None: it goes on as it would): each takes the trials 0, 1, 2
    ... under its own seed. ``options``: ``{"trial": K}``, environment i begins with trial K + i, under
    a seed of its own with trial K, or a list of their own trials; ``{"set": ...}`` as InsertionEnv;
    ``{"reset_mask": mask}``, an array of N booleans, resets those alone: the others stay where they
    are, and their observations are the last ones.
    ``info`` has InsertionEnv's keys, an array of each, and under ``_KEY`` which environments it is
    of.
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int = 1,
        scene: SceneLike = "bench",
        *,
        render_mode: str | None = None,
        threads: int = 0,
        **task: Any,
    ) -> None:
        if render_mode is not None:
            raise ValueError("render_mode: many fibres are not drawn; make one environment")
        self.num_envs = _whole("num_envs", num_envs, least=1, most=2**20)
        self.render_mode = None
        self.task = Task(scene, **task)
        self.single_observation_space = self.task.observation_space
        self.single_action_space = self.task.action_space
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._threads = _whole("threads", threads, most=_MOST_THREADS)
        self._trials: _core._Trials | None = self._made()
        self._begun = np.zeros(self.num_envs, dtype=bool)
        self._outcome = np.full(self.num_envs, -1)
        self._ended = np.zeros(self.num_envs, dtype=bool)
        # Of each environment: its seed, the trial that was asked for, and how far the next one is.
        self._seeds = np.zeros(self.num_envs, dtype=np.uint64)
        self._asked = np.zeros(self.num_envs, dtype=np.uint64)
        self._stride = np.ones(self.num_envs, dtype=np.uint64)

    def _made(self) -> _core._Trials:
        return _core._Trials(self.num_envs, self.task.periods, self._threads)

    def reset(
        self, *, seed: Any = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        trials = self._open("reset")
        options = checked_options(options, ("reset_mask", "set", "trial"))
        which = self._which(options.get("reset_mask"))
        if not (self._begun | which).all():
            raise ResetNeeded("reset: options['reset_mask'] leaves out some that never were reset")
        settings = options.get("set")
        scene = self.task.changed(settings) if settings else self.task.scene
        seeds, asked, stride = self._numbered(seed, options.get("trial"), which)
        rows = trials.reset(which, scene, seeds, asked)
        self._seeds, self._asked, self._stride = seeds, asked, stride
        self._begun |= which
        # One that ends as it begins says so in its first step.
        self._outcome = np.where(which, -1, self._outcome)
        return self._take(rows), self._info(rows, which)

    def _which(self, mask: Any) -> np.ndarray:
        if mask is None:
            return np.ones(self.num_envs, dtype=bool)
        which = np.array(mask)
        if which.shape != (self.num_envs,) or which.dtype != np.bool_ or not which.any():
            raise ValueError(
                f"options['reset_mask'] = {mask!r}: expected {self.num_envs} booleans, one True"
            )
        return which

    def _numbered(
        self, seed: Any, trial: Any, which: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Seeds, trials and strides of all, with those of ``which`` at their new ones."""
        count = self.num_envs
        seeds, asked, stride = self._seeds.copy(), self._asked.copy(), self._stride.copy()
        asked[which] += stride[which]  # where nothing else is said, they go on
        own = seed is not None and np.ndim(seed) > 0
        given = list(seed) if own else [seed] * count
        if len(given) != count:
            raise ValueError(f"seed: expected one, or {count} of them, got {len(given)}")
        anew = which & np.array([own and each is not None for each in given])
        for i in np.flatnonzero(anew):
            seeds[i], asked[i], stride[i] = _whole("seed", given[i]), 0, 1
        # Together: under the seed that was given, or at the first time a drawn one.
        together = which & ~anew & ((seed is not None and not own) | ~self._begun)
        if together.any():
            one = None if own or seed is None else _whole("seed", seed)
            self._np_random, _ = gymnasium.utils.seeding.np_random(one)
            seeds[together] = int(self._np_random.integers(2**31)) if one is None else one
            asked[together], stride[together] = np.flatnonzero(together), count
        if trial is not None and np.ndim(trial) > 0:
            if len(trial) != count:
                raise ValueError(f"options['trial']: expected one, or {count}, got {len(trial)}")
            asked[which] = np.array([trial_number(k) for k in trial], dtype=np.uint64)[which]
        elif trial is not None:
            offset = np.where(stride > 1, np.arange(count), 0).astype(np.uint64)
            asked[which] = np.uint64(trial_number(trial)) + offset[which]
        return seeds, asked, stride

    def step(
        self, actions: Any
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        trials = self._open("step")
        if not self._begun.all():
            raise ResetNeeded("step: call reset first")
        velocity = self.task.velocity(actions)
        if velocity.shape != (self.num_envs, 5):
            raise ValueError(
                f"actions: expected shape ({self.num_envs}, 5), got {velocity.shape}"
            )
        again, before = self._ended, self._tip[:, 0]
        self._asked[again] += self._stride[again]
        velocity = np.ascontiguousarray(velocity)
        rows = trials.step(velocity, again, self.task.scene, self._seeds, self._asked)
        self._outcome = rows[:, _COLUMN["outcome"]].astype(np.int64)
        self._outcome[again] = -1
        observation = self._take(rows)
        reward = self.task.reward(before, self._tip[:, 0], self._outcome)
        reward[again] = 0.0
        truncated = self._outcome == TIMEOUT
        terminated = self._ended != truncated
        everyone = np.ones(self.num_envs, dtype=bool)
        return observation, reward, terminated, truncated, self._info(rows, everyone)

    def close_extras(self, **kwargs: Any) -> None:
        self._trials = None

    def __getstate__(self) -> dict[str, Any]:
        # The same trials go the same way again, bit for bit.
        trials = self._trials
        kept = trials.kept() if trials is not None and self._begun.all() else None
        return {**self.__dict__, "_trials": (trials is not None, kept)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        is_open, kept = state["_trials"]
        self._trials = self._made() if is_open else None
        if kept is not None:
            self._trials.resume(kept)

    def _open(self, what: str) -> _core._Trials:
        if self.closed or self._trials is None:
            raise ClosedEnvironmentError(f"{what}: the environment was closed")
        return self._trials

    def _take(self, rows: np.ndarray) -> np.ndarray:
        self._tip = rows[:, _TIP]
        self._ended = self._outcome >= 0
        return self.task.observation(rows[:, :7], rows[:, 7:12], rows[:, _MOTION])

    def _info(self, rows: np.ndarray, of: np.ndarray) -> dict[str, Any]:
        info: dict[str, Any] = {
            "tip": self._tip.copy(),
            "inserted_length_m": np.maximum(0.0, -self._tip[:, 0]),
            "peak_force_N": rows[:, _COLUMN["peak_force"]],
            "trial": self._open("info").numbers(),
            "seed": self._seeds.copy(),
        }
        info.update({f"_{key}": of.copy() for key in info})
        ended = self._ended & of
        if ended.any():
            info["outcome"] = np.array(
                [outcomes[o] if o >= 0 else None for o in self._outcome], dtype=object
            )
            info["is_success"] = self._outcome == INSERTED
            info["_outcome"], info["_is_success"] = ended, ended.copy()
        return info
