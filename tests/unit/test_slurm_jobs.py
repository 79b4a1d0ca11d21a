"""A Slurm that refuses: one sentence, and the sweep ends; a site that forbids a line of the job gets none of it."""

import os
import stat
import sys

import pandas as pd
import pytest

from taichi_silo.errors import RunFailed
from taichi_silo.studies.sweep.clusters import Slurm
from taichi_silo.studies.sweep.slurm_jobs import Submissions, reason
from tests.unit.test_sweep import command

pytestmark = pytest.mark.skipif(os.name != "posix", reason="programs of the shell stand for Slurm's")
REFUSES = "#!/bin/sh\necho 'sbatch: error: Batch job submission failed: Invalid account' >&2\nexit 1\n"


def program(folder, name, text):
    file = folder / name
    file.write_text(text)
    file.chmod(file.stat().st_mode | stat.S_IXUSR)


def test_a_sweep_ends_in_a_sentence_when_slurm_refuses_its_jobs(tmp_path, monkeypatch, capfd):
    pytest.importorskip("dask_jobqueue")
    program(tmp_path, "sbatch", REFUSES)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    file = tmp_path / "sweep.toml"
    file.write_text(
        "[scene]\n'grid.cell_size_m' = 0.05\n'flow.displacement_m' = 0.002\n[grid]\n"
        "'sand.void_ratio' = [0.6, 0.7]\n[cluster]\nkind = 'slurm'\njobs = 2\ncores = 1\ninterface = 'lo'\n"
    )
    with pytest.raises(RunFailed, match="in 2 of 2 runs.*Slurm refuses the job: Batch job submission failed: Invalid"):
        command(file, output=tmp_path / "out", quiet=True)
    assert pd.read_csv(tmp_path / "out" / "sweep.csv").failure.str.contains("Invalid account").all()
    assert "Traceback" not in "".join(capfd.readouterr())


def test_what_a_site_forbids_is_left_out_of_the_job(tmp_path):
    pytest.importorskip("dask_jobqueue")
    with Slurm(cores=8, leave_out=("--mem", "--cpus-per-task")).cluster(tmp_path) as slurm:
        script = slurm.job_script()
    assert "--mem=" not in script and "--cpus-per-task" not in script
    assert "#SBATCH -t 24:00:00" in script and sys.executable in script


def test_a_refusal_counts_once_no_job_is_left():
    """Fewer jobs than were asked for do the sweep more slowly, but they do it."""
    heard, jobs = [], Submissions()
    jobs.refused = heard.append
    jobs.there, jobs.why = {"7"}, "QOSMaxSubmitJobPerUserLimit"
    jobs.look()
    assert not heard
    jobs.there.discard("7")
    jobs.look()
    assert heard == ["Slurm refuses the job: QOSMaxSubmitJobPerUserLimit"]


def test_the_reason_is_what_sbatch_said():
    told = RuntimeError("Command exited\nstdout:\n\nstderr:\nsbatch: error: Invalid qos\nsbatch: error: x\n")
    assert reason(told) == "Invalid qos sbatch: error: x"
