"""A policy learned in the Gymnasium environment as a program that ``evaluate --policy`` asks."""

from __future__ import annotations

import json
import sys
from typing import Any, Callable, Mapping, TextIO

import numpy as np

from . import BadInput
from .task import Task


def answer(
    environment: Mapping[str, Any],
    act: Callable[[np.ndarray], Any],
    reset: Callable[[], Any] = lambda: None,
    out: TextIO | None = None,
) -> None:
    """Answers the observations on stdin with velocities, a line each, until stdin ends.

    ``environment``: arguments of ferrule/Insertion-v0 that it was learned with. ``act``: its action
    (5,) for the environment's observation, float32. ``reset``: called before every trial.
    ``out``: where the program listens, unless stdout (which must carry nothing else). Raises
    BadInput where it was learned from wrenches that are not relative to rest: the program tells
    relative ones.
    """
    task = Task(**environment)
    if not task.relative:
        raise BadInput("relative = False: the program tells the wrench relative to rest; export "
                       "the episodes with --relative")
    for line in sys.stdin:
        asked = json.loads(line)
        if "reset" in asked:
            reset()
            answered: dict[str, Any] = {}
        else:
            values = np.array([*asked["wrench"], asked["depth"], asked["time"]])
            motion = np.array([*asked["displacement"], asked["height"]])
            action = act(task.observation(values, values[:5], motion))
            answered = {"velocity": task.velocity(action).tolist()}
        print(json.dumps(answered), file=out or sys.stdout, flush=True)
