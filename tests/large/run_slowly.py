"""Runs `segment_file` in small stretches that take their time, to be killed.

python run_slowly.py FILE OUT LOG [resume]
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import geohue.large.stages as stages
from geohue.large import segment_file
from geohue.large.passes import LabelJob, label

STRETCH = 1000


def slow_label(job: LabelJob) -> list[int]:
    """Label a stretch, and note that it was done here."""
    with Path(sys.argv[3]).open("a") as log:
        log.write(f"{job.start}\n")
    time.sleep(0.05)
    return label(job)


if __name__ == "__main__":
    vars(stages).update(JOB=STRETCH, label=slow_label)
    segment_file(
        sys.argv[1],
        sys.argv[2],
        k=3,
        weight=1.0,
        processes=1,
        formats=["ply"],
        resume=sys.argv[4:] == ["resume"],
    )
