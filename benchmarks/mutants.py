"""How many small faults in the core the tests notice: ``make mutants``.

A mutant is a copy of the package with one operator, number, comparison or condition changed. It is
killed if the tests of its room fail. A sample is drawn from all places that can be changed, the
same for the same seed. Six faults that the tests once let through come first (mutants.toml).

    python -m benchmarks.mutants --each 20 --seed 0 -o out/mutants.json
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator

ROOT = Path(__file__).parents[1]
NAMED = ROOT / "benchmarks" / "mutants.toml"

WORDS = "killed", "late", "equivalent", "alive"
LEAST = 0.85
"""The share of mutants that the tests have to notice."""

# Fuzzing takes long and finds little that the laws do not.
QUICKLY = "-x", "-q", "-p", "no:cacheprovider", "--hypothesis-seed=0", "--ignore-glob=*test_fuzz_*"
AT_HOME = "-c", str(ROOT / "pyproject.toml"), "--rootdir", str(ROOT)

# Room, and the tests that answer for it. The file's own examples and tests run first.
ROOMS = {
    "features": ["features", "prepared", "segmentation/test_segment.py"],
    "ncut": ["ncut", "segmentation/test_segment.py"],
    "weight": ["weight", "segmentation/test_segment.py"],
    "consensus": ["consensus", "segmentation/test_segment.py"],
    "regions": ["regions", "merge"],
    "fill": ["fill"],
    "merge": ["merge"],
    "segmentation": ["segmentation", "merge/test_segment.py", "sensors/test_trinocular.py"],
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
    """What the tests said to a mutant ("killed", "late", "alive", "equivalent"), in how long."""

    room: str
    mutant: Mutant
    word: str
    seconds: float


def places(text: str) -> list[tuple[str, int]]:
    """Find every change of a file: the operator's name, and which of its places it is."""
    nodes = list(ast_nodes(get_ast(text)))
    found = []
    for name in OPERATORS:
        operator = get_operator(name)()
        count = sum(1 for node in nodes for _ in operator.mutation_positions(node))
        found += [(name, occurrence) for occurrence in range(count)]
    return found


def _difference(path: str, text: str, changed: str) -> Mutant | None:
    """Return where two texts differ; None for what is no code that runs (a type, an import)."""
    pairs = zip(text.splitlines(), changed.splitlines(), strict=False)
    for at, (before, after) in enumerate(pairs, 1):
        if before != after:
            plain = before.strip()
            if plain.startswith(("import ", "from ", '"', "@")) or "TYPE_CHECKING" in plain:
                return None
            if "not not " in after or "reshape(- 2" in after:  # the same to whatever asks
                return None
            return Mutant(path, at, plain, after.strip())
    return None


def drawn(room: str, each: int, seed: int) -> list[tuple[Mutant, str]]:
    """Draw some mutants of a room, files weighted by the places that can be changed."""
    rng = random.Random(f"{room}/{seed}")
    base = ROOT / "src" / "geohue"
    texts = {str(f.relative_to(base)): f.read_text("utf-8") for f in (base / room).rglob("*.py")}
    found = [(path, *place) for path in sorted(texts) for place in places(texts[path])]
    rng.shuffle(found)
    chosen: list[tuple[Mutant, str]] = []
    for path, name, occurrence in found:
        changed = mutate_code(texts[path], get_operator(name)(), occurrence)
        mutant = _difference(path, texts[path], changed) if changed else None
        if mutant is not None and len(chosen) < each:
            chosen.append((mutant, str(changed)))
        if len(chosen) == each:
            break
    return chosen


class Bench:
    """A copy of the package that mutants are put into, one after the other.

    What was compiled without a mutant is kept. Each mutant gets a copy of it, and compiles again
    only what its change touches.
    """

    def __init__(self, folder: Path) -> None:
        self.package = folder / "src" / "geohue"
        shutil.copytree(
            ROOT / "src" / "geohue",
            self.package,
            ignore=shutil.ignore_patterns("__pycache__"),
        )
        self._kept, self._own = folder / "compiled", folder / "compiled-of-mutant"
        self._kept.mkdir()
        self._count = 0
        self.environment = os.environ | {
            "PYTHONPATH": f"{folder / 'src'}{os.pathsep}{ROOT / 'tests'}",
            "PYTHONPYCACHEPREFIX": str(folder / "bytes"),
            "HYPOTHESIS_STORAGE_DIRECTORY": str(folder / "examples"),
        }

    def passes(self, tests: list[str], limit: float, compiled: Path | None = None) -> bool:
        """Whether the tests pass.

        Raises
        ------
        subprocess.TimeoutExpired
            If they take longer than `limit` seconds.
        """
        kept = {"NUMBA_CACHE_DIR": str(compiled or self._kept)}
        running = subprocess.Popen(
            [sys.executable, "-m", "pytest", *QUICKLY, *AT_HOME, *tests],
            cwd=ROOT,
            env=self.environment | kept,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        try:
            return running.wait(limit) == 0
        finally:
            _end(running)

    def survives(self, mutant: Mutant, text: str, tests: list[str], limit: float) -> bool:
        """Whether the tests pass with a mutant in place."""
        file = self.package / mutant.path
        tests = [str(file), *tests]  # its examples first
        kept, stamp = file.read_bytes(), file.stat()
        shutil.rmtree(self._own, ignore_errors=True)
        shutil.copytree(self._kept, self._own)
        file.write_text(text, "utf-8")
        # Bytecode is known by whole seconds and sizes: no two mutants may have the same.
        self._count += 1
        os.utime(file, (stamp.st_atime, stamp.st_mtime + self._count))
        try:
            return self.passes(tests, limit, self._own)
        finally:
            file.write_bytes(kept)
            os.utime(file, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))


def _end(running: subprocess.Popen[bytes]) -> None:
    """End the tests and all that they started, if they still run."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(running.pid, signal.SIGKILL)
    running.wait()


def tests_of(room: str, path: str) -> list[str]:
    """Return the tests of a file: those of its name first."""
    chosen = [f"tests/{name}" for name in ROOMS[room]]
    own = ROOT / "tests" / room / f"test_{Path(path).stem}.py"
    return [str(own.relative_to(ROOT)), *chosen] if own.exists() else chosen


def judge(bench: Bench, room: str, mutants: list[tuple[Mutant, str]]) -> Iterator[Verdict]:
    """Run the tests of a room for each mutant."""
    start = time.perf_counter()
    if not bench.passes([str(bench.package / room), *tests_of(room, "")], 3600):
        raise SystemExit(f"{room}: the tests fail without a mutant")
    limit = 120 + 3 * (time.perf_counter() - start)
    same = equivalents()
    for mutant, text in mutants:
        start = time.perf_counter()
        if (mutant.path, mutant.before, mutant.after) in same:
            word = "equivalent"
        else:
            try:
                alive = bench.survives(mutant, text, tests_of(room, mutant.path), limit)
                word = "alive" if alive else "killed"
            except subprocess.TimeoutExpired:
                word = "late"
        yield Verdict(room, mutant, word, time.perf_counter() - start)


def equivalents() -> dict[tuple[str, str, str], str]:
    """Return the mutants that change nothing that can be seen: path, before, after; and why."""
    entries = tomllib.loads(NAMED.read_text("utf-8")).get("equivalent", [])
    return {(entry["path"], entry["before"], entry["after"]): entry["why"] for entry in entries}


def known() -> dict[str, list[tuple[Mutant, str]]]:
    """Return the faults that tests once let through, by room."""
    found: dict[str, list[tuple[Mutant, str]]] = {}
    base = ROOT / "src" / "geohue"
    for entry in tomllib.loads(NAMED.read_text("utf-8"))["known"]:
        text = (base / entry["path"]).read_text("utf-8")
        if entry["before"] not in text:
            raise SystemExit(f"{entry['path']}: no longer has {entry['before']!r}")
        changed = text.replace(entry["before"], entry["after"], 1)
        line = text[: text.index(entry["before"])].count("\n") + 1
        mutant = Mutant(entry["path"], line, entry["before"], entry["after"])
        room = entry["path"].split("/")[0]
        found.setdefault(HOMES.get(room, room), []).append((mutant, changed))
    return found


def left_alive(report: Path) -> dict[str, list[tuple[Mutant, str]]]:
    """Return the mutants that an earlier run left alive, by room; those that still apply."""
    found: dict[str, list[tuple[Mutant, str]]] = {}
    for entry in json.loads(report.read_text("utf-8")):
        mutant = Mutant(**entry["mutant"])
        lines = (ROOT / "src" / "geohue" / mutant.path).read_text("utf-8").splitlines(True)
        line = lines[mutant.line - 1] if mutant.line <= len(lines) else ""
        if entry["word"] == "alive" and mutant.before in line:
            lines[mutant.line - 1] = line.replace(mutant.before, mutant.after, 1)
            found.setdefault(entry["room"], []).append((mutant, "".join(lines)))
    return found


def main() -> None:
    """Draw, judge and report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--each", type=int, default=20, help="mutants of each room")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--rooms", default=",".join(ROOMS))
    parser.add_argument("--again", type=Path, help="only what this report says is alive")
    parser.add_argument("-o", "--output", type=Path, default=Path("out/mutants.json"))
    given = parser.parse_args()
    given.output.parent.mkdir(parents=True, exist_ok=True)
    verdicts: list[Verdict] = []
    named = left_alive(given.again) if given.again else known()
    each = 0 if given.again else given.each
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(Path(folder))
        for room in given.rooms.split(","):
            mutants = named.get(room, []) + drawn(room, each, given.seed)
            for verdict in judge(bench, room, mutants) if mutants else ():
                m = verdict.mutant
                print(f"{verdict.word:10} {m.path}:{m.line}: {m.before}  ->  {m.after}", flush=True)
                verdicts.append(verdict)
                given.output.write_text(json.dumps([asdict(v) for v in verdicts], indent=1))
    print(table(verdicts))
    sys.exit(share(verdicts) < LEAST)


def share(verdicts: list[Verdict]) -> float:
    """Return the share of mutants that the tests notice, or that change nothing."""
    return 1 - sum(v.word == "alive" for v in verdicts) / max(1, len(verdicts))


def table(verdicts: list[Verdict]) -> str:
    """Return a line for each room, and one for all; "late" is also noticed."""
    rooms = list(dict.fromkeys(v.room for v in verdicts))
    lines = []
    for name, these in [(r, [v for v in verdicts if v.room == r]) for r in rooms] + [
        ("all", verdicts)
    ]:
        words = Counter(v.word for v in these)
        counts = ", ".join(f"{words[word]} {word}" for word in WORDS)
        lines.append(f"{name:14} {share(these):4.0%} of {len(these)}: {counts}")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
