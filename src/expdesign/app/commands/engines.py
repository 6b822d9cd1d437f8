"""Where the work of a command is done: in this process, in processes of this machine, or on a cluster."""

from expdesign.app.sweeps.engine import Engine, Processes, Serial
from expdesign.errors import InputError
from expdesign.processors import processors


def engine_of(workers: int | None, cluster: str | None, default: int | None = None) -> Engine:
    """The engine of the options `--workers` and `--cluster`, to be used as a context.

    Args:
        workers: number of processes.
        cluster: address of a Dask scheduler.
        default: number of processes where neither is given; as many as there are processors to use if left out.

    Raises:
        InputError: both are given, or one is wrong.
    """
    if cluster is not None:
        if workers is not None:
            remedy = "Workers of a cluster are started with it (`dask worker ADDRESS --nthreads 1`)."
            raise InputError("only one of `--workers` and `--cluster` can be given", where="--workers", remedy=remedy)
        from expdesign.app.sweeps.cluster import Cluster  # noqa: PLC0415 (an extra)

        return Cluster(cluster)
    if workers is not None and workers < 1:
        raise InputError(f"{workers} is not a number of processes", where="--workers", remedy="Use at least 1.")
    count = workers or default or processors()
    return Serial() if count == 1 else Processes(count)


def elsewhere(engine: Engine) -> Engine | None:
    """The engine where it is another process or machine: work that stays in this one needs nothing to be sent."""
    return None if isinstance(engine, Serial) else engine
