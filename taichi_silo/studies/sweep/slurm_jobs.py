"""Jobs of Slurm whose refusal is heard: else a sweep would wait for ever for what is never begun."""

from collections.abc import Callable

from taichi_silo.utils.messages import sentence


class Submissions:
    """Which jobs Slurm has taken; `refused` hears a sentence once it refuses one and none is left.

    Attributes
    ----------
    refused : called with the sentence.
    there : numbers of the jobs that Slurm has taken and that have not ended.
    why : what `sbatch` said of the last job that it refused.

    """

    def __init__(self) -> None:
        self.refused: Callable[[str], None] = lambda words: None
        self.there: set[str] = set()
        self.why = ""

    def job_class(self) -> type:
        """The class of a job for a cluster of dask_jobqueue, which tells of its start and end."""
        try:
            from dask_jobqueue.slurm import SLURMJob
        except ImportError as error:
            from taichi_silo.errors import BadInput
            from taichi_silo.studies.sweep.clusters import NEEDED

            raise BadInput(NEEDED) from error
        submissions = self

        class Job(SLURMJob):
            """A job that a refusal of `sbatch` does not end in a traceback."""

            async def start(self) -> None:
                try:
                    await super().start()
                except (RuntimeError, ValueError, OSError) as error:
                    self.status = type(self.status).running  # nobody waits for it
                    submissions.why = reason(error)
                    submissions.look()
                else:
                    submissions.there.add(self.job_id)

            async def close(self) -> None:
                await super().close()
                submissions.there.discard(self.job_id)
                submissions.look()

        return Job

    def look(self) -> None:
        """Say so where nothing will be done any more."""
        if self.why and not self.there:
            self.refused(f"Slurm refuses the job: {self.why}")


def reason(error: Exception) -> str:
    """What `sbatch` said, in one line."""
    said = str(error).partition("stderr:")[2] or str(error)
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    return sentence(" ".join(lines)).removeprefix("sbatch: ").removeprefix("error: ")
