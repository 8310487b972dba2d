"""How many small faults in the core the tests notice: ``make mutants``.

A mutant is a copy of the package with one operator, number, comparison or condition changed. It is
killed if the tests of its room fail. A sample is drawn from all places that can be changed, the
same for the same seed. Six faults that the tests once let through come first (mutants.toml).

    python -m benchmarks.mutants --each 20 --seed 0 -o out/mutants.json
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator

ROOT = Path(__file__).parents[1]
EQUIVALENT = ROOT / "benchmarks" / "mutants.toml"

# Room, and the tests that answer for it. Those of a file's own name run first.
ROOMS = {
    "features": ["features", "prepared", "segmentation/test_segment.py"],
    "ncut": ["ncut", "segmentation/test_segment.py"],
    "weight": ["weight", "segmentation/test_segment.py"],
    "consensus": ["consensus", "segmentation/test_segment.py"],
    "regions": ["regions", "merge"],
    "fill": ["fill"],
    "merge": ["merge"],
    "segmentation": ["segmentation", "merge/test_segment.py"],
}

HOMES = {"settings": "consensus"}
"""The room whose tests answer for a known fault outside of the rooms."""

# One change for each operator: more say the same again.
OPERATORS = [
    *(
        f"core/ReplaceBinaryOperator_{old}_{new}"
        for old, new in (
            ("Add", "Sub"),
            ("Sub", "Add"),
            ("Mul", "Div"),
            ("Div", "Mul"),
            ("FloorDiv", "Mul"),
            ("Mod", "Mul"),
            ("Pow", "Mul"),
            ("BitAnd", "BitOr"),
        )
    ),
    *(
        f"core/ReplaceComparisonOperator_{old}_{new}"
        for old, new in (
            ("Lt", "LtE"),
            ("Lt", "Gt"),
            ("LtE", "Lt"),
            ("Gt", "GtE"),
            ("Gt", "Lt"),
            ("GtE", "Gt"),
            ("Eq", "NotEq"),
            ("NotEq", "Eq"),
        )
    ),
    "core/ReplaceAndWithOr",
    "core/ReplaceOrWithAnd",
    "core/ReplaceTrueWithFalse",
    "core/ReplaceFalseWithTrue",
    "core/ReplaceBreakWithContinue",
    "core/AddNot",
    "core/NumberReplacer",
    "core/ZeroIterationForLoop",
]


@dataclass(frozen=True)
class Mutant:
    """One change: the file (below src/geohue), its line, and the line before and after."""

    path: str
    line: int
    before: str
    after: str


@dataclass(frozen=True)
class Verdict:
    """What the tests said to a mutant, and in how many seconds."""

    mutant: Mutant
    killed: bool
    seconds: float
    equivalent: str = ""


def changes(path: str, text: str) -> Iterator[tuple[Mutant, str]]:
    """Find every change of a file: the mutant and the whole text with it."""
    for name in OPERATORS:
        operator = get_operator(name)()
        for occurrence in range(10_000):
            changed = mutate_code(text, operator, occurrence)
            if changed is None:
                break
            mutant = _difference(path, text, changed)
            if mutant is not None:
                yield mutant, changed


def _difference(path: str, text: str, changed: str) -> Mutant | None:
    """Return where two texts differ; None for what is no code that runs (a type, an import)."""
    pairs = zip(text.splitlines(), changed.splitlines(), strict=False)
    for at, (before, after) in enumerate(pairs, 1):
        if before != after:
            plain = before.strip()
            if plain.startswith(("import ", "from ", '"', "@")) or "TYPE_CHECKING" in plain:
                return None
            if "not not " in after:  # the same to whatever asks
                return None
            return Mutant(path, at, plain, after.strip())
    return None


def drawn(room: str, each: int, seed: int) -> list[tuple[Mutant, str]]:
    """Draw some mutants of a room, files weighted by the places that can be changed."""
    rng = random.Random(f"{room}/{seed}")
    found: list[tuple[Mutant, str]] = []
    base = ROOT / "src" / "geohue"
    for file in sorted((base / room).rglob("*.py")):
        found += changes(str(file.relative_to(base)), file.read_text("utf-8"))
    return rng.sample(found, min(each, len(found)))


class Bench:
    """A copy of the package that mutants are put into, one after the other."""

    def __init__(self, folder: Path) -> None:
        self.package = folder / "src" / "geohue"
        shutil.copytree(
            ROOT / "src" / "geohue",
            self.package,
            ignore=shutil.ignore_patterns("__pycache__"),
        )
        self.environment = os.environ | {
            "PYTHONPATH": f"{folder / 'src'}{os.pathsep}{ROOT / 'tests'}",
            "NUMBA_CACHE_DIR": str(folder / "compiled"),
            "PYTHONDONTWRITEBYTECODE": "1",
        }

    def passes(self, tests: list[str], limit: float) -> bool:
        """Whether the tests pass within a time."""
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
        try:
            done = subprocess.run(
                command, cwd=ROOT, env=self.environment, capture_output=True, timeout=limit
            )
        except subprocess.TimeoutExpired:
            return False
        return done.returncode == 0

    def survives(self, mutant: Mutant, text: str, tests: list[str], limit: float) -> bool:
        """Whether the tests pass with a mutant in place."""
        file = self.package / mutant.path
        kept, stamp = file.read_bytes(), file.stat()
        file.write_text(text, "utf-8")
        try:
            return self.passes(tests, limit)
        finally:
            file.write_bytes(kept)
            os.utime(file, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))


def tests_of(room: str, path: str) -> list[str]:
    """Return the tests of a file: those of its name first."""
    chosen = [f"tests/{name}" for name in ROOMS[room]]
    own = ROOT / "tests" / room / f"test_{Path(path).stem}.py"
    return [str(own.relative_to(ROOT)), *chosen] if own.exists() else chosen


def judge(room: str, mutants: list[tuple[Mutant, str]]) -> Iterator[Verdict]:
    """Run the tests of a room for each mutant."""
    equivalent = {
        (entry["path"], entry["before"], entry["after"]): entry["why"]
        for entry in tomllib.loads(EQUIVALENT.read_text("utf-8")).get("equivalent", [])
    }
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(Path(folder))
        start = time.perf_counter()
        if not bench.passes(tests_of(room, ""), 3600):
            raise SystemExit(f"{room}: the tests fail without a mutant")
        limit = 120 + 3 * (time.perf_counter() - start)
        for mutant, text in mutants:
            start = time.perf_counter()
            why = equivalent.get((mutant.path, mutant.before, mutant.after), "")
            killed = not why and not bench.survives(
                mutant, text, tests_of(room, mutant.path), limit
            )
            yield Verdict(mutant, killed, time.perf_counter() - start, why)


def known() -> dict[str, list[tuple[Mutant, str]]]:
    """Return the faults that tests once let through, by room."""
    found: dict[str, list[tuple[Mutant, str]]] = {}
    base = ROOT / "src" / "geohue"
    for entry in tomllib.loads(EQUIVALENT.read_text("utf-8"))["known"]:
        text = (base / entry["path"]).read_text("utf-8")
        if entry["before"] not in text:
            raise SystemExit(f"{entry['path']}: no longer has {entry['before']!r}")
        changed = text.replace(entry["before"], entry["after"], 1)
        line = text[: text.index(entry["before"])].count("\n") + 1
        mutant = Mutant(entry["path"], line, entry["before"], entry["after"])
        room = entry["path"].split("/")[0]
        found.setdefault(HOMES.get(room, room), []).append((mutant, changed))
    return found


def main() -> None:
    """Draw, judge and report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--each", type=int, default=20, help="mutants of each room")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--rooms", default=",".join(ROOMS))
    parser.add_argument("-o", "--output", type=Path, default=Path("out/mutants.json"))
    given = parser.parse_args()
    verdicts: list[Verdict] = []
    named = known()
    for room in given.rooms.split(","):
        mutants = named.get(room, []) + drawn(room, given.each, given.seed)
        for verdict in judge(room, mutants):
            word = "equivalent" if verdict.equivalent else "killed" if verdict.killed else "ALIVE"
            m = verdict.mutant
            print(f"{word:10} {m.path}:{m.line}: {m.before}  ->  {m.after}", flush=True)
            verdicts.append(verdict)
            given.output.parent.mkdir(parents=True, exist_ok=True)
            given.output.write_text(json.dumps([asdict(v) for v in verdicts], indent=1))
    dead = sum(v.killed or bool(v.equivalent) for v in verdicts)
    print(f"{dead} of {len(verdicts)} killed or equivalent: {dead / max(1, len(verdicts)):.0%}")
    sys.exit(dead < 0.85 * len(verdicts))


if __name__ == "__main__":
    main()
