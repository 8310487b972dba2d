"""How long a start takes: imports, the help, and the first run after an installation.

    python benchmarks/startup.py [--rounds 15] [--first-runs 3]

Every figure is a fresh process. Imports and the help: interleaved, medians of all rounds. First
runs: ``geohue segment --sample motorcycle`` with an empty cache of compiled loops, each followed
by two later runs, with what the first one said of it; and again after ``geohue warm``.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter

STARTS = {
    "python": ["-c", "pass"],
    "import numpy": ["-c", "import numpy"],
    "import geohue": ["-c", "import geohue"],
    "import geohue, use it": ["-c", "import geohue; geohue.segment, geohue.Scene"],
    "geohue --help": ["-m", "geohue", "--help"],
}

SEGMENT = ["-m", "geohue", "segment", "--sample", "motorcycle", "--json"]


def timed(arguments: list[str], environment: dict[str, str] | None = None) -> tuple[float, str]:
    """Run Python once; returns the seconds and what it said on standard error."""
    given = os.environ | (environment or {})
    begin = perf_counter()
    done = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, env=given)
    seconds = perf_counter() - begin
    if done.returncode:
        sys.exit(f"{' '.join(arguments)}: {done.stderr}")
    return seconds, done.stderr.strip()


def print_starts(rounds: int) -> None:
    """Print the table of imports."""
    times: dict[str, list[float]] = {name: [] for name in STARTS}
    for turn in range(rounds + 1):
        for name, arguments in STARTS.items():
            seconds, _ = timed(arguments)
            if turn:  # the first reads the files from the disk
                times[name].append(seconds)
    base = median(times["import numpy"])
    print("| fresh process | ms | least to most | to `import numpy` |")
    print("| --- | --: | --: | --: |")
    for name, found in times.items():
        low, high = 1000 * min(found), 1000 * max(found)
        print(f"| {name} | {1000 * median(found):.0f} | {low:.0f} - {high:.0f} ", end="")
        print(f"| {median(found) / base:.2f} |")


def print_first_runs(count: int) -> None:
    """Print the table of first and later runs."""
    first, later, warming, warmed = [], [], [], []
    said = ""
    for _ in range(count):
        with TemporaryDirectory() as folder:
            cache = {"NUMBA_CACHE_DIR": str(Path(folder))}
            seconds, said = timed(SEGMENT, cache)
            first.append(seconds)
            later += [timed(SEGMENT, cache)[0] for _ in range(2)]
        with TemporaryDirectory() as folder:
            cache = {"NUMBA_CACHE_DIR": str(Path(folder))}
            warming.append(timed(["-m", "geohue", "warm"], cache)[0])
            seconds, after = timed(SEGMENT, cache)
            warmed.append(seconds)
            if after:
                print(f"after geohue warm: {after}")
    print("\n| `geohue segment --sample motorcycle` | s | least to most |")
    print("| --- | --: | --: |")
    rows = {
        "first run": first,
        "later runs": later,
        "`geohue warm`": warming,
        "first run after it": warmed,
    }
    for name, found in rows.items():
        print(f"| {name} | {median(found):.2f} | {min(found):.2f} - {max(found):.2f} |")
    print(f"\nWhat a first run says: {said}")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--first-runs", type=int, default=3)
    given = parser.parse_args()
    print_starts(given.rounds)
    print_first_runs(given.first_runs)


if __name__ == "__main__":
    main()
