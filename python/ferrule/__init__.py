"""Insertion of an optical fibre into a ferrule: simulated, recorded, learned, evaluated.

A thin layer over the program's own loop: what is stepped or evaluated here has the same bits as
there. Velocities, wrenches and depths that controllers know are those of the hand's world
(Scene.motion_scale, Scene.force_scale times the tip's); states and forces are the tip's.

    import ferrule
    controller = ferrule.fit(ferrule.record("bench", "episodes"))
    print(ferrule.evaluate(controller).success_rate)
    simulator = ferrule.Simulator("bench")
    observation = simulator.reset(seed=7, trial=0)
    while not simulator.ended:
        observation = simulator.step(controller(observation))
    print(simulator.ended, simulator.summary)
"""

from __future__ import annotations

import json as _json
import operator as _operator
import os as _os
import tempfile as _tempfile
from dataclasses import dataclass as _dataclass
from pathlib import Path as _Path
from typing import TYPE_CHECKING, Any, Callable, Mapping, Sequence, Union

from . import _core
from ._core import (
    BadInput,
    Controller,
    FileTrouble,
    Observation,
    Scene,
    load,
    outcomes,
    shipped_scenes,
)

from .registration import register_when_imported as _register_when_imported

if TYPE_CHECKING:
    import numpy as np

_register_when_imported()
__version__: str = _core.__version__
#: Names of the force laws, in the order of Simulator.forces and of an episode's columns.
terms: list[str] = list(_core._terms)

#: The name of a scene that ships, a file, a document (a mapping), or a scene.
SceneLike = Union[str, _os.PathLike, Mapping[str, Any], Scene]
#: Dotted keys and their values, or texts "key=value" as after --set.
Overrides = Union[Mapping[str, Any], Sequence[str], None]
#: Answers an observation with a velocity: 5 numbers [m/s, rad/s], hand's world. Where it has a
#: method `reset`, that is called before every trial.
Policy = Callable[[Observation], Any]

__all__ = [
    "BadInput", "Controller", "Episode", "Evaluation", "FileTrouble", "Observation", "Overrides",
    "Policy", "Scene", "SceneLike", "Simulator", "compare", "evaluate", "fit", "forces", "load",
    "load_scene", "outcomes", "plot", "record", "shipped_scenes", "terms", "validate",
]


def _whole(name: str, value: Any, least: int = 0, most: int = 2**64 - 1) -> int:
    """``value`` as an int, NumPy's too. Raises BadInput where it is none, or out of bounds."""
    try:
        number = _operator.index(value)
    except TypeError:
        number = least - 1
    if not least <= number <= most:
        raise BadInput(f"{name} = {value!r}: must be a whole number from {least} to {most}")
    return number


def _text(document: Any) -> str:
    """As JSON, whatever mappings it is made of, and with the numbers and arrays of NumPy."""

    def plain(value: Any) -> Any:
        if hasattr(value, "tolist"):
            return value.tolist()
        if isinstance(value, Mapping):
            return dict(value)
        raise BadInput(f"{value!r}: is nothing that JSON can say")

    return _json.dumps(document, default=plain)


#: As the program's --threads.
_MOST_THREADS = 4096


def _settings(overrides: Overrides) -> list[str]:
    if overrides is None:
        return []
    if isinstance(overrides, Mapping):
        return [f"{key}={_text(value)}" for key, value in overrides.items()]
    if isinstance(overrides, str):
        return [overrides]
    return list(overrides)


def load_scene(scene: SceneLike = "demo", overrides: Overrides = None) -> Scene:
    """The scene of a name, a file, a document or another scene, with some values changed.

    ``overrides``: ``{"ferrule.bore_diameter_um": 125.5}`` or ``["ferrule.bore_diameter_um=125.5"]``;
    None removes a law. Where the scene states an accuracy, what it does not need is left out, as
    the program does; that takes some seconds. Raises BadInput with the program's text ("FILE: KEY
    = VALUE: RULE") and FileTrouble.
    """
    return _load(scene, overrides, plan=True)


def _load(scene: SceneLike, overrides: Overrides, plan: bool) -> Scene:
    settings = _settings(overrides)
    if isinstance(scene, Scene):
        return _core._parse_scene(scene.json, scene.name, settings, plan) if settings else scene
    if isinstance(scene, Mapping):
        name = str(scene.get("name", "scene"))
        return _core._parse_scene(_text(scene), name, settings, plan)
    return _core._load_scene(scene, settings, plan)


def _scene_again(document: str, name: str) -> Scene:
    return _core._parse_scene(document, name, [], False)


def _itself(self: Any, memo: Any = None) -> Any:
    return self


# What does not change is its own copy; a scene goes to other processes as its document.
Scene.__reduce__ = lambda self: (_scene_again, (self.json, self.name))  # type: ignore[method-assign]
Scene.__copy__ = Scene.__deepcopy__ = _itself  # type: ignore[attr-defined]


def _controller_again(files: dict[str, bytes], more: tuple[Any, ...]) -> Controller:
    with _tempfile.TemporaryDirectory() as folder:
        for name, content in files.items():
            (_Path(folder) / name).write_bytes(content)
        file = str(_Path(folder) / "controller.json") if files else None
        return _core._controller_again(file, more)


def _controller_state(self: Controller) -> tuple[Any, ...]:
    """What its file holds, and the weights beside it. What it observed stays here."""
    with _tempfile.TemporaryDirectory() as folder:
        if self._has_file:
            self.save(_Path(folder) / "controller.json")
        files = {file.name: file.read_bytes() for file in _Path(folder).iterdir()}
    return _controller_again, (files, self._more)


Controller.__reduce__ = _controller_state  # type: ignore[method-assign]


def validate(scene: SceneLike, overrides: Overrides = None) -> None:
    """Raises BadInput or FileTrouble with the program's text unless the scene is right."""
    _load(scene, overrides, plan=False)


class Simulator(_core._Simulator):
    """One insertion, period by period, with the bits of a trial of the program.

    ``scene``, ``overrides``: as for load_scene. ``period`` [s]: of control and simulation.
    """

    def __init__(
        self, scene: SceneLike = "demo", overrides: Overrides = None, period: float = 1e-3
    ) -> None:
        super().__init__(load_scene(scene, overrides), float(period))

    def reset(self, seed: int = 7, trial: int = 0, feasible: bool = False) -> Observation:
        """To the start of trial ``trial`` of a campaign under ``seed``; the observation there.

        ``feasible``: where the drawn parts do not fit, the next trial whose do (trial + 2**32 ...).
        """
        return super().reset(_whole("seed", seed), _whole("trial", trial), bool(feasible))

    def __reduce__(self) -> tuple[Any, ...]:
        # The same trial goes the same way again, bit for bit.
        state = {"kept": self._kept(), "more": vars(self)}
        return _simulator_again, (type(self), self.scene, self.period), state

    def __setstate__(self, state: dict[str, Any]) -> None:
        if state["kept"] is not None:
            self._resume(state["kept"])
        vars(self).update(state["more"])


def _simulator_again(kind: type[Simulator], scene: Scene, period: float) -> Simulator:
    simulator = kind.__new__(kind)
    Simulator.__init__(simulator, scene, period=period)
    return simulator


class Episode(_core._Episode):
    """A recorded insertion: NumPy views of its rows, not copied and not to be written to.

    ``file``: what ``ferrule record`` wrote. Raises FileTrouble where it is none, or damaged. An
    episode goes to other processes as the name of its file, which they read again.
    """

    def __init__(self, file: str | _os.PathLike) -> None:
        super().__init__(file)
        self._file = _os.path.abspath(file)

    def __reduce__(self) -> tuple[Any, ...]:
        return Episode, (self._file,)

    __copy__ = __deepcopy__ = _itself

    @property
    def scene(self) -> dict[str, Any]:
        """The document of the scene it was recorded in."""
        return _json.loads(self.scene_json)

    @property
    def phase(self) -> np.ndarray:
        """What the operator was at in each row, "" where it does not say; shape (N,)."""
        import numpy as np

        begins = [0, *(row for row, _ in self.phases), len(self)]
        return np.repeat(["", *(name for _, name in self.phases)], np.diff(begins))

    def force(self, term: str) -> np.ndarray:
        """The force of one of ferrule.terms on the fibre: x, y, z [N], shape (N, 3)."""
        if term not in terms:
            raise BadInput(f"there is no force {term}; there are {', '.join(terms)}")
        first = 3 * terms.index(term)
        return self.forces[:, first : first + 3]


@_dataclass(frozen=True)
class Evaluation:
    """What a policy did in the trials 0 to N - 1 under one seed."""

    statistics: dict[str, Any]  #: with the keys of ``ferrule evaluate --json``
    outcome: list[str]  #: of each trial
    #: of each trial, shape (N,), by the name with its unit, as in time_s: peak_stress_Pa,
    #: friction_work_J, depth_m, offset_m, tilt_rad, touched_s (< 0: never), ...
    numbers: dict[str, np.ndarray]

    @property
    def success_rate(self) -> float:
        """Of the feasible trials."""
        return self.statistics["success_rate"]

    @property
    def time_s(self) -> np.ndarray:
        """Of each trial [s]."""
        return self.numbers["time_s"]

    @property
    def peak_force_N(self) -> np.ndarray:
        """Of each trial [N]."""
        return self.numbers["peak_force_N"]

    @property
    def loss_dB(self) -> np.ndarray:
        """Of each trial; NaN unless inserted or high_loss."""
        return self.numbers["loss_dB"]


def evaluate(
    policy: Controller | Policy | str | _os.PathLike,
    scene: SceneLike | None = None,
    trials: int = 1000,
    seed: int = 7,
    *,
    overrides: Overrides = None,
    supervise: bool = False,
    threads: int = 0,
) -> Evaluation:
    """The trials and the statistics of ``ferrule evaluate``.

    ``policy``: a controller, what ``load`` takes, or any callable from an Observation to a velocity
    (5 numbers [m/s, rad/s], hand's world), called every millisecond of every trial, on one thread;
    what it raises ends the evaluation. ``scene``: None takes that of the
    controller's training, or ``demo``; BadInput is raised where it scales the hand otherwise, unless
    the controller's ``other_scaling`` is set. ``threads``: 0 for all cores. Ctrl-C ends it.
    """
    if isinstance(policy, (str, _os.PathLike)):
        policy = load(policy)
    if not callable(policy):
        raise TypeError("policy: expected a controller, a file, or a callable")
    trials, seed = _whole("trials", trials, 1, 10**8), _whole("seed", seed)
    threads = _whole("threads", threads, most=_MOST_THREADS)
    if scene is None:
        brought = policy.scene_json if isinstance(policy, Controller) else None
        scene = _json.loads(brought) if brought else "demo"
    found = _core._evaluate(policy, load_scene(scene, overrides), trials, seed, supervise, threads)
    return Evaluation(_json.loads(found[0]), *found[1:])


def forces(
    scene: SceneLike = "demo",
    gap_nm: Any = 10.0,
    length_um: Any = 100.0,
    depth_nm: Any = None,
    *,
    overrides: Overrides = None,
    tilt_mrad: float = 0.0,
    speed_um_s: float = 10.0,
) -> dict[str, np.ndarray]:
    """The forces between fibre and bore, as ``ferrule forces`` has them.

    Arrays of smallest gaps [nm], inserted lengths [um] and penetrations [nm] (None: apart) are
    broadcast; nothing of the scene is left out. Returns for each of ferrule.terms an array of that
    shape [N], attraction negative, and "squeeze", the film's force at ``speed_um_s`` [um/s].
    Raises BadInput where a gap cannot be.
    """
    import numpy as np

    given = [gap_nm, length_um, np.nan if depth_nm is None else depth_nm]
    arrays = np.broadcast_arrays(*(np.asarray(x, dtype=float) for x in given))
    if any((a < 0).any() for a in arrays) or np.isnan(arrays[:2]).any():
        raise BadInput("gap_nm, length_um, depth_nm: must be numbers, not negative")
    flat = [np.ascontiguousarray(a).ravel() for a in arrays]
    rows = _core._forces(
        _load(scene, overrides, plan=False), *flat, float(tilt_mrad), float(speed_um_s)
    )
    return {
        name: rows[:, column].reshape(arrays[0].shape)
        for column, name in enumerate([*terms, "squeeze"])
    }


from . import plot  # noqa: E402
from .learning import compare, fit, record  # noqa: E402
