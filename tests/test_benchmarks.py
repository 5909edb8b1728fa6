"""Benchmarks can start: what each imports, of fowtlib and of other benchmarks, is there."""

import subprocess
import sys
from pathlib import Path

FOLDER = Path(__file__).parent.parent / "benchmarks"
IMPORT = "import importlib, sys; [importlib.import_module(name) for name in sys.argv[1:]]"


def test_every_benchmark_can_start():
    names = sorted(path.stem for path in FOLDER.glob("*.py"))
    assert "p4_optimum" in names and len(names) > 40
    run = subprocess.run([sys.executable, "-c", IMPORT, *names], cwd=FOLDER, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
