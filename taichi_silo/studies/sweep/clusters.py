"""Where the runs of a sweep are done: on the cores of this machine, at a scheduler's workers, or in jobs of Slurm."""

import contextlib
import shutil
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from taichi_silo.errors import BadInput
from taichi_silo.scene.scene import cores
from taichi_silo.utils.messages import counted
from taichi_silo.utils.process_pool import ProcessPool, Task, run_task, stop_tasks
from taichi_silo.utils.schema import Options

LOST_S = 120  # within which a worker that died must be back; on a busy machine its start takes a while
ANSWER_S = 20  # within which a scheduler must answer
NEEDED = (
    "a sweep on a cluster needs taichi-silo[cluster], which brings dask.distributed: pip install 'taichi-silo[cluster]'"
)


class DaskPool(ProcessPool):
    """`jobs` tasks at a time at the workers of a client of dask; a worker begins one whose process crashed again.

    A task whose worker dies is begun again as often as the scheduler allows.
    """

    def __init__(self, client, jobs: int, retries: int):
        super().__init__(jobs, retries)
        self.client = client
        self.refusal = ""
        self._waiting: list[Future] = []

    def refuse(self, sentence: str) -> None:
        """Begin no more tasks, and give up those that wait, because nothing will ever do them."""
        self.refusal = sentence

        def give_up() -> None:
            for future in list(self._waiting):
                future.cancel()

        threading.Thread(target=give_up, daemon=True).start()  # a client that is told in its own thread waits for ever

    @contextlib.contextmanager
    def _workers(self, heard: Callable[[str, float], None]) -> Iterator[Callable[[Task], Future]]:
        """A function that submits a task; `heard` hears what workers say, as events of a topic of this pool."""
        self.client.subscribe_topic(self.key, lambda event: heard(*event[1]))
        executor = self.client.get_executor(pure=False)

        def submit(task: Task) -> Future:
            future = executor.submit(at_worker, task, self.key, self.retries, priority=task.seconds)
            self._waiting.append(future)
            if self.refusal:
                future.cancel()
            return future

        try:
            yield submit
        finally:
            with contextlib.suppress(Exception):  # a scheduler that is gone
                self.client.unsubscribe_topic(self.key)

    def _stop(self, kill: bool = False) -> int:
        """Ask all tasks to stop, or kill them; returns how many there still are."""
        try:
            return sum(self.client.run(stop_tasks, self.key, kill, on_error="ignore").values())
        except Exception:  # noqa: BLE001 - workers that are gone have stopped
            return 0

    def _failure(self, future: Future) -> str:
        """Why a task failed; empty if it did not."""
        from distributed import KilledWorker

        if future.cancelled() and self.refusal:
            return self.refusal
        error = None if future.cancelled() else future.exception()
        if isinstance(error, KilledWorker):
            return f"{error.allowed_failures + 1} workers died while they ran it"
        return super()._failure(future)


def at_worker(task: Task, pool: str, retries: int) -> str:
    """Run a task in a process of its own beside a worker; its parts that are done go to the topic `pool`."""
    from distributed import get_worker

    worker = get_worker()
    return run_task(task, pool, retries, lambda *said: worker.log_event(pool, said))


class Local(Options):
    """Processes on this machine, one a core."""

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
        """Refuse more runs at a time than cores."""
        if self.at_once > cores():
            raise BadInput(f"jobs is {self.jobs}; this machine has {counted(cores(), 'core')}")

    @contextlib.contextmanager
    def pool(self, folder: Path, runs: int, retries: int) -> Iterator[ProcessPool]:
        """What does the runs."""
        yield ProcessPool(self.at_once, retries)


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
    leave_out: tuple[str, ...] = Field(
        (), description="lines of #SBATCH that the site forbids, such as --mem and --cpus-per-task"
    )
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
        need_dask()
        if shutil.which("sbatch") is None:
            raise BadInput("cluster is slurm; it must be another kind on this machine, which has no sbatch")

    @contextlib.contextmanager
    def pool(self, folder: Path, runs: int, retries: int) -> Iterator[ProcessPool]:
        """What does the runs: jobs, of which no more are needed than the runs fill; others follow those that end."""
        jobs = min(self.jobs, -(-runs // self.cores))
        from taichi_silo.studies.sweep.slurm_jobs import Submissions

        submissions = Submissions()
        with (
            dask_settings(retries),
            self.cluster(folder, submissions.job_class()) as cluster,
            cluster.get_client() as client,
        ):
            pool = DaskPool(client, self.at_once, retries)
            submissions.refused = pool.refuse
            cluster.adapt(minimum_jobs=jobs, maximum_jobs=jobs)
            yield pool

    def cluster(self, folder: Path, job_class: Any = None):
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
            job_name="taichi-silo", log_directory=str(folder / "slurm"), worker_extra_args=["--no-dashboard"],
            scheduler_options={"dashboard": False, "dashboard_address": ":0"},
            job_directives_skip=list(self.leave_out), job_cls=job_class,
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
        need_dask()

    @contextlib.contextmanager
    def pool(self, folder: Path, runs: int, retries: int) -> Iterator[ProcessPool]:
        """What does the runs; raises BadInput if the scheduler does not answer."""
        from distributed import Client

        with dask_settings(retries):
            try:
                client = Client(self.address, timeout=ANSWER_S, set_as_default=False)
            except (OSError, ValueError) as error:
                raise BadInput(f"scheduler is {self.address}; no scheduler of dask answers there") from error
            with client:
                yield DaskPool(client, max(sum(client.ncores().values()), 1), retries)


Cluster = Local | Slurm | Scheduler


def cluster_of(scheduler: str | None, slurm: bool, jobs: int | None, otherwise: Cluster | None = None) -> Cluster:
    """What the flags of a command name, else another one, else this machine; raises BadInput if they contradict."""
    if scheduler is not None and slurm:
        raise BadInput("scheduler and slurm are both given; it must be one of them")
    cluster = otherwise or Local()
    if scheduler is not None:
        cluster = Scheduler(address=scheduler)
    elif slurm and not isinstance(cluster, Slurm):
        cluster = Slurm()
    return cluster if jobs is None else cluster.with_jobs(jobs)


def need_dask() -> None:
    """Refuse a machine without dask.distributed."""
    try:
        import distributed  # noqa: F401
    except ImportError as error:
        raise BadInput(NEEDED) from error


def dask_settings(retries: int):
    """A context in which a run survives the deaths of `retries` workers, and none waits behind another one."""
    import dask

    return dask.config.set({
        "distributed.scheduler.allowed-failures": retries,
        "distributed.scheduler.worker-saturation": 1.0,
        "distributed.deploy.lost-worker-timeout": LOST_S,
    })  # fmt: skip
