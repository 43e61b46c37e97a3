"""Start workers through SLURM and stay until interrupted; `glmref run` runs beside it."""

import signal

from dask_jobqueue import SLURMCluster

if __name__ == "__main__":
    with SLURMCluster() as cluster:  # what it asks for stands in slurm.yaml
        cluster.adapt(minimum_jobs=1, maximum_jobs=100)
        print(f"glmref run resonance-map --on dask:{cluster.scheduler_address}")  # noqa: T201
        signal.pause()
