"""Makes ferrule/Insertion-v0 known to Gymnasium, without the tenth of a second of importing it.

Where Gymnasium loads the entry points `gymnasium.envs`, as before 1.0, it needs no import of ferrule.
"""

from __future__ import annotations

import importlib.util
import sys
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any


def register() -> None:
    from gymnasium.envs.registration import register as add
    from gymnasium.envs.registration import registry

    if "ferrule/Insertion-v0" not in registry:
        add(
            id="ferrule/Insertion-v0",
            entry_point="ferrule.insertion_env:InsertionEnv",
            vector_entry_point="ferrule.insertion_vector_env:InsertionVectorEnv",
        )


class _OnceImported(MetaPathFinder):
    """Registers right after Gymnasium is imported."""

    def find_spec(self, name: str, path: Any, target: Any = None) -> ModuleSpec | None:
        if name != "gymnasium":
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(name)
        if spec is None or spec.loader is None:
            return None
        loader = spec.loader
        execute = loader.exec_module

        def exec_module(module: ModuleType) -> None:
            execute(module)
            register()

        loader.exec_module = exec_module  # type: ignore[method-assign]
        return spec


def register_when_imported() -> None:
    """Now, where Gymnasium has been imported, or when it is."""
    if "gymnasium" in sys.modules:
        register()
    else:
        sys.meta_path.insert(0, _OnceImported())
