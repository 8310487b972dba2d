"""A batch of its own process, slow enough to be killed in the middle."""

from __future__ import annotations

import sys
import time
from typing import Any

from geohue.cli.app import main
from geohue.studies.batch import run as module

if __name__ == "__main__":
    run = module.run_task

    def slowly(task: module.Task) -> dict[str, Any]:
        row = run(task)
        time.sleep(0.3)
        return row

    module.run_task = slowly
    main(["batch", *sys.argv[1:]])
