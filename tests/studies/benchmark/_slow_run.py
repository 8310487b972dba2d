"""A benchmark run of its own process, slow enough to be killed in the middle."""

from __future__ import annotations

import sys
import time
from pathlib import Path

from geohue.studies.benchmark import run as module
from geohue.studies.benchmark.trials import Conditions, plan

if __name__ == "__main__":
    run = module.measure

    def slowly(job: module.Measurement) -> dict[str, object]:
        time.sleep(0.4)
        return run(job)

    module.measure = slowly
    module.benchmark(
        sys.argv[1],
        Path(sys.argv[2]),
        plan(["nncsc"], ["fusion", "color"], ["fast"]),
        Conditions(k=2),
        resume=True,
    )
