import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
#: The program, as ./ferrule builds it.
PROGRAM = os.environ.get("FERRULE_PROGRAM", str(ROOT / "build/app/ferrule"))


def run(*arguments: str, code: int = 0) -> subprocess.CompletedProcess:
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == code, done.stderr
    return done


os.environ["FERRULE_PYTHON"] = sys.executable  # what export-episodes runs


@pytest.fixture(scope="session")
def episodes(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("recorded") / "episodes"
    run("record", "--scene", "bench", "--episodes", 4, "--skill", 0.8, "--seed", 1, "--out", folder)
    return folder


@pytest.fixture(scope="session")
def law(episodes) -> str:
    file = episodes.parent / "law.json"
    run("fit", episodes, "--method", "ceres", "--out", file)
    return str(file)
