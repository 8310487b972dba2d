"""A guard against slower revisions: two of them, measured turn by turn in one run.

    python -m benchmarks.guard BASE [HEAD] [--rounds 9] [--tolerance 1.25] [--cases cut,fill]

BASE and HEAD are revisions of git; without HEAD, the files as they are now. Each measurement is a
fresh process; the two revisions alternate, so that a busy moment hits both. Exit status 1 if a
case got slower (or larger) than the tolerance, beyond the noise and when asked again. Neither
pytest-benchmark, which knows one revision a run, nor asv, which builds an environment for each,
measures two source trees with the same libraries in alternation.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.guard.cases import CASES, SINGLE
from benchmarks.guard.judge import Comparison, compare
from benchmarks.guard.trees import check_out, write_inputs

NAMES = (*CASES, *SINGLE)


def measure(case: str, tree: Path, inputs: Path) -> float | str:
    """Measure a case with one revision; returns the value, or why there is none."""
    script = Path(__file__).with_name("cases.py")
    done = subprocess.run(
        [sys.executable, str(script), case, str(inputs)],
        env=os.environ | {"PYTHONPATH": str(tree)},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        return done.stderr.strip().splitlines()[-1]
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    if Path(found["used"]) != tree:
        sys.exit(f"{found['used']} was measured instead of {tree}: PYTHONPATH has no effect here")
    return str(found["missing"]) if "missing" in found else float(found["value"])


def run_case(
    case: str, trees: list[Path], inputs: Path, rounds: int, tolerance: float
) -> Comparison | str:
    """Measure a case with both revisions in turn, after one process each that compiles."""
    series: list[list[float]] = [[], []]
    for turn in range(rounds + 1):
        # Each goes first every other time.
        for which in (0, 1) if turn % 2 else (1, 0):
            value = measure(case, trees[which], inputs)
            if isinstance(value, str):
                return f"{('base', 'head')[which]}: {value}"
            if turn:
                series[which].append(value)
    return compare(series[0], series[1], tolerance)


def row(case: str, found: Comparison | str) -> str:
    """Write a line of the table."""
    if isinstance(found, str):
        return f"| {case} | | | | | skipped: {found} |"
    unit = 1 if "(MB)" in case else 1000
    return (
        f"| {case} | {unit * found.base:.1f} | {unit * found.head:.1f} | {found.ratio:.2f} "
        f"| {found.low:.2f} - {found.high:.2f} | {found.verdict} |"
    )


def main() -> None:
    """Print the table; exit with 1 if something got slower."""
    given = _arguments()
    print(f"| ms | {given.base} | {given.head or 'now'} | ratio | half of the pairs | |")
    print("| --- | --: | --: | --: | --: | --- |", flush=True)
    slower = []
    with TemporaryDirectory() as name:
        folder = Path(name).resolve()
        trees = [check_out(given.base, folder / "base"), check_out(given.head, folder / "head")]
        write_inputs(folder)
        for case in given.cases:
            found = run_case(case, trees, folder, given.rounds, given.tolerance)
            if isinstance(found, Comparison) and found.verdict == "slower":
                # Some case of a dozen is slower by chance now and then, hardly twice.
                found = run_case(case, trees, folder, given.rounds, given.tolerance)
            print(row(case, found), flush=True)
            if isinstance(found, Comparison) and found.verdict == "slower":
                slower.append(case)
    if slower:
        sys.exit(f"slower than {given.tolerance:g} times: {', '.join(slower)}")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("base")
    parser.add_argument("head", nargs="?")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--tolerance", type=float, default=1.25)
    parser.add_argument("--cases", type=_case_names, default=NAMES, metavar="NAME,NAME")
    given = parser.parse_args()
    if given.rounds < 5 or given.tolerance < 1:
        parser.error("expected at least 5 rounds and a tolerance of at least 1")
    return given


def _case_names(text: str) -> tuple[str, ...]:
    """Pick cases by the beginnings of their names."""
    wanted = text.split(",")
    unknown = [word for word in wanted if not any(name.startswith(word) for name in NAMES)]
    if unknown:
        raise argparse.ArgumentTypeError(f"no case {unknown[0]}: {', '.join(NAMES)}")
    return tuple(name for name in NAMES if name.startswith(tuple(wanted)))


if __name__ == "__main__":
    main()
