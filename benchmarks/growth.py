"""Time and peak memory against the number of points.

    python benchmarks/growth.py --scratch DIR [--largest 100000000] [--format laz] [--preset best]

Clouds of 10^4 to 10^8 points are made in DIR from the real one of GEOHUE_DATA (churo_uav): every
n-th of its points, or shifted copies of it side by side, each with a jitter of 2 cm so that no two
points coincide. Each is segmented in a process of its own, in pieces (`--memory 2GB`) and, up to
10^7, whole; the sizes take turns, and medians are printed. Peak memory is the resident memory of
the process and all its children together, looked at every 20 ms.
"""

from __future__ import annotations

import argparse
import os
import platform
import resource
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np
from numpy.typing import NDArray

from geohue.large.sample import SAMPLE
from geohue.read.clouds.chunks import open_chunks
from geohue.read.extras import optional

_PAGE = os.sysconf("SC_PAGE_SIZE")
_JITTER = 0.02  # metres, against a spacing of about 1 m
_PIECE = 1_000_000
_WHOLE = """
import sys, numpy as np, geohue
from geohue.read.scenes.scenes import read_scene
np.save(sys.argv[2], geohue.segment(read_scene(sys.argv[1]), k=6, preset=sys.argv[3]).labels)
"""


@dataclass(frozen=True, slots=True)
class Run:
    """Seconds, seconds of processor and bytes of one process with its children."""

    seconds: float
    processor: float
    peak: int


def pieces(n_points: int, source: Path) -> Iterator[tuple[NDArray[np.float64], NDArray[np.uint8]]]:
    """Yield a cloud of so many points, piece by piece."""
    chunks = open_chunks(source)
    xyz, rgb = chunks.read(0, chunks.n_points)
    chunks.close()
    if n_points < len(xyz):
        rows = np.linspace(0, len(xyz) - 1, n_points).astype(np.int64)
        xyz, rgb = xyz[rows], rgb[rows]
    size = xyz.max(axis=0) - xyz.min(axis=0)
    side = int(np.ceil(np.sqrt(n_points / len(xyz))))
    rng = np.random.default_rng(0)
    for tile, first in enumerate(range(0, n_points, len(xyz))):
        count = min(len(xyz), n_points - first)
        shift = np.array([tile % side, tile // side, 0]) * size
        for start in range(0, count, _PIECE):
            part = slice(start, min(start + _PIECE, count))
            jitter = rng.uniform(-_JITTER, _JITTER, xyz[part].shape)
            yield xyz[part] + shift + jitter, rgb[part]


def make_cloud(file: Path, n_points: int, source: Path) -> None:
    """Write a cloud, if it is not there yet."""
    if file.exists():
        return
    part = file.with_name("part-" + file.name)
    if file.suffix == ".npy":
        rows = np.lib.format.open_memmap(part, "w+", np.float64, (n_points, 6))
        done = 0
        for xyz, rgb in pieces(n_points, source):
            rows[done : done + len(xyz)] = np.hstack([xyz, rgb])
            done += len(xyz)
        rows.flush()
    else:
        write_las(part, n_points, source)
    part.replace(file)


def write_las(file: Path, n_points: int, source: Path) -> None:
    """Write LAS or LAZ as surveyors do: millimetres, 16-bit colours."""
    laspy = optional("laspy", "clouds", file)
    header = laspy.LasHeader(point_format=2, version="1.2")
    header.scales, header.offsets = np.full(3, 0.001), np.array([870682.0, 8502674.0, 3352.0])
    with laspy.open(file, "w", header=header) as writer:
        for xyz, rgb in pieces(n_points, source):
            record = laspy.ScaleAwarePointRecord.zeros(len(xyz), header=header)
            for i, (axis, color) in enumerate(zip("xyz", ("red", "green", "blue"), strict=True)):
                record[axis] = xyz[:, i]
                record[color] = rgb[:, i].astype(np.uint16) << 8
            writer.write_points(record)


def measured(command: list[str]) -> Run:
    """Run a command and watch its memory and that of its children."""
    begin, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    peak = 0
    while process.poll() is None:
        peak = max(peak, resident(process.pid))
        time.sleep(0.02)
    seconds = time.perf_counter() - begin
    if process.returncode != 0:
        _, text = process.communicate()
        raise SystemExit(f"{' '.join(command)}: {text.decode()}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Run(seconds, used, peak)


def resident(pid: int) -> int:
    """Return the resident bytes of a process and of all that it started."""
    total, todo = 0, [pid]
    while todo:
        one = todo.pop()
        try:
            total += int(Path(f"/proc/{one}/statm").read_text().split()[1]) * _PAGE
            for task in Path(f"/proc/{one}/task").iterdir():
                todo += map(int, (task / "children").read_text().split())
        except (FileNotFoundError, ProcessLookupError):
            continue
    return total


def commands(file: Path, out: Path, memory: str, preset: str) -> dict[str, list[str]]:
    """Return how to segment a cloud, by the names of the ways."""
    piecewise = [sys.executable, "-m", "geohue", "segment", str(file), "-k", "6", "-o", str(out)]
    piecewise += ["--preset", preset]
    return {
        "in pieces": [*piecewise, "--memory", memory],
        "whole": [sys.executable, "-c", _WHOLE, str(file), str(out / "labels.npy"), preset],
    }


def line_through(sizes: list[int], seconds: list[float]) -> tuple[float, float]:
    """Fit t = a + b N with the least relative error."""
    t = np.array(seconds)
    columns = np.stack([np.ones(len(t)), np.array(sizes)], axis=1) / t[:, None]
    (a, b), *_ = np.linalg.lstsq(columns, np.ones(len(t)), rcond=None)
    return float(a), float(b)


def exponent(sizes: list[int], seconds: list[float]) -> float:
    """Return the slope of log t against log N."""
    return float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])


def report(way: str, results: dict[int, list[Run]]) -> None:
    """Print the table of one way, its line and its exponents."""
    print(f"\n{way}\n\n| points | s | processor s | peak MB |\n|" + " ---: |" * 4)
    sizes = sorted(results)
    for n in sizes:
        seconds = median(run.seconds for run in results[n])
        processor = median(run.processor for run in results[n])
        peak = max(run.peak for run in results[n]) / 1e6
        print(f"| {n:,} | {seconds:.2f} | {processor:.2f} | {peak:.0f} |")
    print()
    growth("time", sizes, [median(run.seconds for run in results[n]) for n in sizes])
    growth("processor", sizes, [median(run.processor for run in results[n]) for n in sizes])


def growth(name: str, sizes: list[int], seconds: list[float]) -> None:
    """Print the line and the exponents of one measure.

    The line is drawn where the sample on which all is decided is full; below it, less is done.
    """
    print(f"{name}: exponent over all {exponent(sizes, seconds):.2f}", end="")
    full = [i for i, n in enumerate(sizes) if n >= SAMPLE]
    large = [i for i in full if sizes[i] >= 10**6]
    if len(large) > 1:
        n, t = np.array(sizes), np.array(seconds)
        a, b = line_through(n[full].tolist(), t[full].tolist())
        off = np.abs(a + b * n[full] - t[full]) / t[full]
        print(f", from 10^6 on {exponent(n[large].tolist(), t[large].tolist()):.2f}", end="")
        print(f"; from 10^5 on {a:.2f} s + {1e6 * b:.3f} us * N", end="")
        print(f", at most {100 * off.max():.0f} % off", end="")
        if (t[large] > a).all():
            net = exponent(n[large].tolist(), (t[large] - a).tolist())
            print(f"; from 10^6 on, less the {a:.1f} s that every run takes: {net:.2f}", end="")
    print()


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scratch", type=Path, required=True)
    parser.add_argument("--smallest", type=int, default=10**4)
    parser.add_argument("--largest", type=int, default=10**8)
    parser.add_argument("--largest-whole", type=int, default=10**7)
    parser.add_argument("--format", choices=("laz", "las", "npy"), default="laz")
    parser.add_argument("--memory", default="2GB")
    parser.add_argument("--preset", default="best")
    parser.add_argument("--runs", type=int, default=3)
    options = parser.parse_args()
    data = Path(os.environ.get("GEOHUE_DATA", Path(__file__).parents[2] / "shared" / "data"))
    sizes = [10**e for e in range(3, 10) if options.smallest <= 10**e <= options.largest]
    options.scratch.mkdir(parents=True, exist_ok=True)
    files = {n: options.scratch / f"churo-{n}.{options.format}" for n in sizes}
    for n, file in files.items():
        make_cloud(file, n, data / "churo_uav" / "churo_full.laz")
    results: dict[str, dict[int, list[Run]]] = {}
    for turn in range(options.runs):
        for n, file in files.items():
            if turn and n > 10**7:
                continue  # minutes: once
            out = options.scratch / "out"
            for way, command in commands(file, out, options.memory, options.preset).items():
                if way == "whole" and n > options.largest_whole:
                    continue
                shutil.rmtree(out, ignore_errors=True)
                out.mkdir()
                run = measured(command)
                results.setdefault(way, {}).setdefault(n, []).append(run)
                print(f"{way} {n}: {run}", file=sys.stderr)
    print(f"{options.format}, {os.cpu_count()} cores, Python {platform.python_version()}")
    for way, runs in results.items():
        report(way, runs)


if __name__ == "__main__":
    main()
