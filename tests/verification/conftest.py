import sys
from pathlib import Path

# verification_cases, shared with the page docs/verification.md
sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
