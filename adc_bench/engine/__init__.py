"""Map tasks that may be repeated over this process, over local worker processes, or over a Ray cluster."""

from adc_bench.engine.run import ENGINES, Engine, default_workers, run_tasks
from adc_bench.engine.task import TRIES, Done

__all__ = ["ENGINES", "TRIES", "Done", "Engine", "default_workers", "run_tasks"]
