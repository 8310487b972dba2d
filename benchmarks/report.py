"""Write the tables of benchmark runs, with the version and the machine behind each.

    python -m benchmarks.report NAME=RUN [NAME=RUN ...] [--least N] [--methods A,B]

RUN is the folder of a ``geohue benchmark``, finished or not: trials with fewer than N frames are
left out, and all others are compared on the frames that all of them have.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path

from geohue.jobs.ledger import Ledger, Row
from geohue.jobs.run import SETTINGS
from geohue.studies.benchmark.run import FIELDS, KEYS, TABLE
from geohue.studies.benchmark.summary import by_trial, summarise, table


def comparable(rows: list[Row], least: int, methods: str | None) -> list[Row]:
    """Keep the trials with at least so many frames, and the frames that all of these have."""
    wanted = None if methods is None else methods.split(",")
    groups = [
        group
        for group in by_trial(rows).values()
        if len(group) >= least and (wanted is None or group[0]["method"] in wanted)
    ]
    if not groups:
        return []
    common = set.intersection(*({row["frame"] for row in group} for group in groups))
    return [row for group in groups for row in group if row["frame"] in common]


def report(name: str, run: Path, least: int, methods: str | None) -> Iterator[str]:
    """Yield the lines on one run."""
    settings = json.loads((run / SETTINGS).read_text(encoding="utf-8"))
    machine = settings.pop("machine")
    yield f"### {name}"
    yield ""
    rows = list(Ledger(run / TABLE, FIELDS, KEYS).rows().values())
    summaries = sorted(
        summarise(comparable(rows, least, methods)),
        key=lambda s: s.measures["voi_bits"].mean if s.measures else float("inf"),
    )
    yield table(summaries)
    versions = ", ".join(f"{k} {v}" for k, v in machine.items() if k not in ("cpu", "system"))
    crop = settings["crop"]
    yield (
        f"geohue {settings['version']}; K {settings['k']}, "
        f"{'components' if settings['components'] else 'clusters'} as regions, seed "
        f"{settings['seed']}, {'whole frames' if crop is None else f'crop {crop}'}; "
        f"{machine['cpu']}, {machine['system']}, {versions}."
    )
    yield ""


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", nargs="+", metavar="NAME=RUN")
    parser.add_argument("--least", type=int, default=1)
    parser.add_argument("--methods", help="these only, commas between")
    given = parser.parse_args()
    for pair in given.runs:
        name, _, folder = pair.partition("=")
        print("\n".join(report(name, Path(folder), given.least, given.methods)))


if __name__ == "__main__":
    main()
