"""Where the runs of a sweep are done: on the cores of this machine, at a scheduler's workers, or in jobs of Slurm."""

import contextlib
import logging
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

from pydantic import Field

from taichi_silo.errors import BadInput
from taichi_silo.scene.scene import cores
from taichi_silo.utils.schema import Options

LOST_S = 120  # within which a worker that died must be back; on a busy machine its start takes a while
ANSWER_S = 20  # within which a scheduler must answer
WORKER = "taichi_silo.studies.sweep.ignore_interrupts"  # what each worker of ours imports at its start
NEEDED = "a sweep needs taichi-silo[cluster], which brings dask.distributed: pip install 'taichi-silo[cluster]'"


class Local(Options):
    """Workers on this machine, one a core, that nobody can reach from outside of it."""

    kind: Literal["local"] = "local"
    jobs: int | None = Field(None, ge=1, description="runs at a time; all cores if absent")

    @property
    def at_once(self) -> int:
        """Runs at a time."""
        return self.jobs or cores()

    def with_jobs(self, jobs: int) -> "Local":
        """With so many runs at a time."""
        return self.model_copy(update={"jobs": jobs})

    def check(self) -> None:
        """Refuse more workers than cores, and a machine without dask.distributed."""
        need_distributed()
        if self.at_once > cores():
            raise BadInput(f"jobs is {self.jobs}; this machine has 1 to {cores()} cores")

    def make(self, folder: Path, runs: int):
        """Begin the workers, of which no more are needed than there are runs."""
        from distributed import LocalCluster

        return LocalCluster(
            n_workers=min(self.at_once, runs), threads_per_worker=1, processes=True, host="127.0.0.1", memory_limit=0,
            dashboard_address=None, scheduler_kwargs={"dashboard": False, "dashboard_address": "127.0.0.1:0"},
            silence_logs=logging.CRITICAL, preload=[WORKER],
        )  # fmt: skip


class Slurm(Options):
    """Jobs of Slurm, in each of which `cores` runs are done at a time; the output must be on a shared file system."""

    kind: Literal["slurm"] = "slurm"
    jobs: int = Field(1, ge=1, description="of Slurm")
    cores: int = Field(16, ge=1, description="of a job")
    memory: str | None = Field(None, description="of a job, such as 32GB; 2 GB a core if absent")
    walltime: str = Field("24:00:00", description="of a job; runs that it cuts off are begun again")
    queue: str | None = Field(None, description="partition")
    account: str | None = None
    interface: str | None = Field(None, description="network on which the workers reach this machine, such as ib0")
    job_extra: tuple[str, ...] = Field((), description="more lines of #SBATCH, such as --exclusive")
    prologue: tuple[str, ...] = Field((), description="lines of the job before the workers, such as module load python")

    @property
    def at_once(self) -> int:
        """Runs at a time."""
        return self.jobs * self.cores

    def with_jobs(self, jobs: int) -> "Slurm":
        """With so many runs at a time, or some more that fill the last job of Slurm."""
        return self.model_copy(update={"jobs": -(-jobs // self.cores)})

    def check(self) -> None:
        """Refuse a machine without dask or Slurm."""
        need_distributed()
        if shutil.which("sbatch") is None:
            raise BadInput("cluster is slurm; it must be another kind on this machine, which has no sbatch")

    def make(self, folder: Path, runs: int):
        """Submit the jobs, of which no more are needed than the runs fill, and others for those that end before."""
        cluster, jobs = self.prepared(folder), min(self.jobs, -(-runs // self.cores))
        cluster.adapt(minimum_jobs=jobs, maximum_jobs=jobs)
        return cluster

    def prepared(self, folder: Path):
        """The cluster, before any job; what the jobs say goes to `folder`/slurm.

        A job is one worker, a thread of which waits for each run: only of such jobs it is noticed that they ended.
        """
        try:
            from dask_jobqueue import SLURMCluster
        except ImportError as error:
            raise BadInput(NEEDED) from error
        return SLURMCluster(
            cores=self.cores, processes=1, memory=self.memory or f"{2 * self.cores}GB", queue=self.queue,
            walltime=self.walltime, account=self.account, interface=self.interface,
            job_extra_directives=list(self.job_extra), job_script_prologue=list(self.prologue),
            job_name="taichi-silo", log_directory=str(folder / "slurm"),
            worker_extra_args=["--preload", WORKER, "--no-dashboard"],
            scheduler_options={"dashboard": False, "dashboard_address": ":0"},
        )  # fmt: skip


class Scheduler(Options):
    """The workers of a scheduler of dask; they must have taichi_silo, and the output on a shared file system."""

    kind: Literal["scheduler"] = "scheduler"
    address: str = Field(description="such as tcp://host:8786")

    @property
    def at_once(self) -> None:
        """Runs at a time: as many as the scheduler has workers for."""
        return None

    def with_jobs(self, jobs: int) -> "Scheduler":
        """Refuse it: the workers are not ours."""
        raise BadInput(f"jobs is {jobs}; it must not be given with a scheduler, which has its own workers")

    def check(self) -> None:
        """Refuse a machine without dask.distributed."""
        need_distributed()


Cluster = Local | Slurm | Scheduler


def need_distributed() -> None:
    """Refuse a machine without dask.distributed."""
    try:
        import distributed  # noqa: F401
    except ImportError as error:
        raise BadInput(NEEDED) from error


@contextlib.contextmanager
def client_of(cluster: Cluster, folder: Path, runs: int, retries: int) -> Iterator:
    """A client of the workers, that are gone afterwards if they were made for it.

    Raises
    ------
    BadInput
        if a scheduler does not answer.

    """
    import dask
    from distributed import Client

    settings = {
        "distributed.scheduler.allowed-failures": retries,  # deaths of workers that a run survives
        "distributed.scheduler.worker-saturation": 1.0,  # no run waits behind another one
        "distributed.deploy.lost-worker-timeout": LOST_S,
        "distributed.admin.system-monitor.gil.enabled": False,
    }
    with dask.config.set(settings), contextlib.ExitStack() as stack:
        if isinstance(cluster, Scheduler):
            try:
                client = stack.enter_context(Client(cluster.address, timeout=ANSWER_S, set_as_default=False))
            except (OSError, ValueError) as error:
                raise BadInput(f"scheduler is {cluster.address}; no scheduler of dask answers there") from error
        else:
            workers = stack.enter_context(cluster.make(folder, runs))
            client = stack.enter_context(Client(workers, set_as_default=False))
        yield client
