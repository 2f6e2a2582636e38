"""Demonstrations recorded, a controller fitted to them, and ways to insert compared."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, Mapping, Sequence

from . import (
    BadInput, Controller, FileTrouble, Overrides, Scene, SceneLike, _MOST_THREADS, _core, _settings,
    _text, _whole, load_scene, program,
)


def record(
    scene: SceneLike,
    folder: str | os.PathLike,
    episodes: int = 20,
    skill: float | str = 0.8,
    seed: int = 1,
    *,
    overrides: Overrides = None,
) -> list[str]:
    """Insertions by the simulated operator, recorded as ``ferrule record`` does; their files.

    ``folder``: is made where it is not there, and must hold no episodes. ``skill``: 0 to 1, or
    with traits of his own: "0.8,bore_yield=0.3".
    Episode k is trial k under ``seed``, or the next whose drawn parts fit. Ctrl-C ends and keeps
    the running episode. Raises BadInput and FileTrouble.
    """
    episodes, seed = _whole("episodes", episodes, 1, 10**6), _whole("seed", seed)
    return _core._record(load_scene(scene, overrides), folder, episodes, str(skill), seed)


def fit(
    episodes: str | os.PathLike | Sequence[str | os.PathLike],
    method: str = "ceres",
    *,
    law: str = "insertion",
    seed: int = 1,
) -> Controller:
    """The controller that ``ferrule fit`` makes of recorded episodes.

    ``episodes``: a folder, a file, or several of them. ``method``: "ceres", a law; "search", the
    numbers of a search by touch, of episodes that tell phases. ``law``: "insertion", or another of
    ``ferrule fit --help``; "auto" chooses by cross-validation. ``seed``: of the split into training
    and held-out episodes. Its result has the gains, those of a law with their intervals, the
    errors, a report and warnings, and ``save(file)``. Raises BadInput where the episodes are too
    few or tell nothing, and FileTrouble.

    Networks (method "torch") are trained by the program; a trained one runs here too.
    """
    if method in ("torch", "policy"):
        raise BadInput(
            "method \"torch\": networks are trained by `ferrule fit --method torch`, where the program "
            "has libtorch (Debian: libtorch-dev, or the package ferrule-torch); trained networks run "
            "everywhere, here by ferrule.load"
        )
    if method not in ("ceres", "law", "search"):
        raise BadInput(f"method: there is no {method}; there are ceres, search, torch")
    places = [episodes] if isinstance(episodes, (str, os.PathLike)) else episodes
    return _core._fit(list(places), method, law, _whole("seed", seed))


def compare(
    episodes: str | os.PathLike,
    scene: SceneLike | None = None,
    trials: int = 1000,
    *,
    learners: Sequence[str] | None = None,
    controllers: Sequence[str | os.PathLike] = (),
    seed: int = 7,
    fit_seed: int = 1,
    overrides: Overrides = None,
    threads: int = 0,
) -> dict[str, Any]:
    """Baselines and learners on the same trials: the document of ``ferrule compare --json``.

    Its "rows" are a table with one row for each way to insert. ``episodes``: a folder to learn
    from. ``scene``: None takes that of the episodes. ``learners``: None takes all that can run
    here. ``controllers``: files to try beside them. The program does it in a process of its own;
    its notes go to stderr. Raises BadInput and FileTrouble with the program's text.
    """
    arguments = [os.fspath(place) for place in (episodes, *controllers)]
    numbers = {"trials": _whole("trials", trials, least=1), "seed": _whole("seed", seed),
               "fit-seed": _whole("fit_seed", fit_seed),
               "threads": _whole("threads", threads, most=_MOST_THREADS)}
    for name, number in numbers.items():
        arguments += [f"--{name}", str(number)]
    if learners is not None:
        arguments += ["--learners", ",".join(learners)]
    for setting in _settings(overrides):
        arguments += ["--set", setting]
    with tempfile.TemporaryDirectory() as folder:
        if isinstance(scene, (Scene, Mapping)):
            document = scene.json if isinstance(scene, Scene) else _text(scene)
            scene = Path(folder) / "scene.json"
            scene.write_text(document)
        if scene is not None:
            arguments += ["--scene", os.fspath(scene)]
        return _program("compare", *arguments, "--json")


def _program(*arguments: str) -> dict[str, Any]:
    """What the program prints as JSON; raises what it refuses."""
    done = subprocess.run([program.path, *arguments], capture_output=True, text=True)
    if done.returncode == 0:
        notes = [line for line in done.stderr.splitlines() if line.startswith("note:")]
        sys.stderr.writelines(note + "\n" for note in notes)
        return json.loads(done.stdout)
    if done.returncode == 130:
        raise KeyboardInterrupt
    said = (done.stderr.splitlines() or [f"{program.path} ended with {done.returncode}"])[-1]
    raise {2: BadInput, 3: FileTrouble}.get(done.returncode, RuntimeError)(
        said.removeprefix("ferrule: ")
    )
