"""Write the tables of benchmark runs, with the version and the machine behind each.

    python -m benchmarks.report NAME=RUN [NAME=RUN ...]

RUN is the folder of a ``geohue benchmark``, finished or not.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path

from geohue.evaluate.benchmark import FIELDS, KEYS, SETTINGS, TABLE
from geohue.evaluate.ledger import Ledger
from geohue.evaluate.summary import summarise, table


def report(name: str, run: Path) -> Iterator[str]:
    """Yield the lines on one run."""
    settings = json.loads((run / SETTINGS).read_text(encoding="utf-8"))
    machine = settings.pop("machine")
    yield f"### {name}"
    yield ""
    rows = Ledger(run / TABLE, FIELDS, KEYS).rows().values()
    summaries = sorted(
        summarise(rows),
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
    given = parser.parse_args()
    for pair in given.runs:
        name, _, folder = pair.partition("=")
        print("\n".join(report(name, Path(folder))))


if __name__ == "__main__":
    main()
