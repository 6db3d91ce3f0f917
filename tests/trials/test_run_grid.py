"""Running a grid: results, resuming, forks."""

from __future__ import annotations

import json
import resource
from concurrent.futures import BrokenExecutor, Future
from dataclasses import replace
from pathlib import Path

import pytest

from wbc.trials import (
    Grid,
    Results,
    ResultsError,
    RobotCases,
    TrialError,
    Workers,
    dask_workers,
    read_results,
    run_grid,
)
from wbc.trials.partial_results import PartialResults
from wbc.trials.provenance import Provenance
from wbc.trials.workers import run_task

pytest.importorskip("mujoco")
pyarrow = pytest.importorskip("pyarrow")
parquet = pytest.importorskip("pyarrow.parquet")

GRID = Grid(
    (RobotCases("simple_humanoid"),),
    sizes=(0.2, 2.0),
    phases=2,
    directions=("left",),
    duration=0.8,
)


class InThisProcess:
    """An executor that runs each function when it is submitted."""

    def submit(self, function, *arguments):
        future = Future()
        try:
            future.set_result(function(*arguments))
        except Exception as error:
            future.set_exception(error)
        return future


WORKERS = Workers(InThisProcess(), 1, "this process")


@pytest.fixture(scope="module")
def results(tmp_path_factory) -> tuple[Results, Path]:
    output = tmp_path_factory.mktemp("trials") / "results.parquet"
    return run_grid(GRID, output, WORKERS), output


def test_results_are_read_back_with_grid_and_versions(results):
    computed, output = results
    assert read_results(output) == computed
    assert computed.grid == GRID
    assert computed.provenance == Provenance.current()
    assert len(computed.trials) == 4
    assert len(computed.runs) == 1
    assert not output.with_name("results.parquet.partial").exists()


def test_a_small_push_is_survived_and_a_huge_one_is_not(results):
    computed, _ = results
    survived = {(row.phase, row.size): row.survived for row in computed.trials}
    assert survived == {(0.0, 0.2): True, (0.0, 2.0): False, (0.5, 0.2): True, (0.5, 2.0): False}
    for row in computed.trials:
        assert row.survived == (row.fell_at_s is None) == (row.reason == "")
        assert row.dcm_error_peak_m > 0.01
        assert row.torque_peak <= 1.0


def test_an_interrupted_grid_goes_on_with_what_is_left_to_the_same_results(results, tmp_path):
    output = tmp_path / "again.parquet"
    shown = []
    stopped = run_grid(
        GRID, output, WORKERS, progress=shown.append, stopped=lambda: shown[-1].finished >= 2
    )
    assert 2 <= len(stopped.rows) < 5
    assert not output.exists()
    partial = output.with_name("again.parquet.partial")
    with partial.open("ab") as file:
        file.write(b'{"key": "cut o')  # as a full disk or a crash leaves it
    shown.clear()
    finished = run_grid(GRID, output, WORKERS, progress=shown.append)
    assert shown[0].finished == len(stopped.rows)
    assert finished == results[0]
    assert output.read_bytes() == results[1].read_bytes()


def test_a_grid_that_grows_repeats_nothing(results):
    computed, output = results
    shown = []
    grown = replace(GRID, sizes=(0.1, 0.2, 2.0), phases=1, name="grown")
    larger = run_grid(grown, output, WORKERS, progress=shown.append)
    assert shown[0].finished == shown[0].total - 1
    assert set(larger.rows) & set(computed.trials) == {
        row for row in computed.trials if row.phase == 0.0
    }
    computed.write(output)


def test_results_of_other_software_are_not_mixed(results, tmp_path):
    computed, _ = results
    output = tmp_path / "old.parquet"
    replace(computed, provenance=replace(computed.provenance, numpy="0.1")).write(output)
    with pytest.raises(ResultsError, match=r"numpy 0\.1 instead of.*--restart"):
        run_grid(GRID, output, WORKERS)
    partial = tmp_path / "new.parquet.partial"
    partial.write_text(json.dumps({"versions": {"numpy": "1"}}) + "\n")
    with pytest.raises(ResultsError, match="does not contain results of this version"):
        run_grid(GRID, tmp_path / "new.parquet", WORKERS)


def test_output_that_cannot_be_written_is_told_before_the_run(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ResultsError, match="cannot write"):
        run_grid(GRID, tmp_path / "file" / "results.parquet", WORKERS)


def test_a_full_disk_ends_the_run_and_keeps_what_was_finished(results, tmp_path):
    output = tmp_path / "full.parquet"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)

    def fill(progress) -> None:
        if progress.finished == 2:
            size = output.with_name("full.parquet.partial").stat().st_size
            resource.setrlimit(resource.RLIMIT_FSIZE, (size + 100, before[1]))

    try:
        with pytest.raises(ResultsError, match=r"cannot write .*; it has 2 results"):
            run_grid(GRID, output, WORKERS, progress=fill)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    shown = []
    assert run_grid(GRID, output, WORKERS, progress=shown.append) == results[0]
    assert shown[0].finished == 2


def test_a_dask_cluster_gives_the_same_results_bit_by_bit(results, tmp_path):
    distributed = pytest.importorskip("distributed")
    settings = {"processes": False, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.LocalCluster(n_workers=2, **settings) as cluster:
        output = tmp_path / "dask.parquet"
        with dask_workers(cluster.scheduler_address) as workers:
            assert workers.count == 2
            run_grid(GRID, output, workers)
    assert output.read_bytes() == results[1].read_bytes()


def test_a_cluster_that_does_not_exist_is_refused():
    pytest.importorskip("distributed")
    with (
        pytest.raises(TrialError, match="no Dask scheduler answers at 'nothing://1'"),
        dask_workers("nothing://1"),
    ):
        pass


def test_workers_with_other_software_are_refused():
    assert run_task(Provenance.current(), max, 1, 2) == 2
    other = replace(Provenance.current(), source="edited")
    with pytest.raises(TrialError, match="another source code of wbc; install the same"):
        run_task(other, max, 1, 2)


def test_a_worker_that_dies_is_told_and_costs_no_finished_trial(results, tmp_path):
    class Dies(InThisProcess):
        count = 0

        def submit(self, function, *arguments):
            self.count += 1
            return super().submit(function if self.count < 3 else self.die, *arguments)

        def die(self, *_):
            raise BrokenExecutor

    output = tmp_path / "results.parquet"
    with pytest.raises(TrialError, match=r"a worker was lost .* run again"):
        run_grid(GRID, output, Workers(Dies(), 1, "mortal workers"))
    shown = []
    assert run_grid(GRID, output, WORKERS, progress=shown.append) == results[0]
    assert shown[0].finished == 2


def test_two_runs_do_not_write_the_same_file(tmp_path):
    path = tmp_path / "results.parquet.partial"
    with (
        PartialResults(path, Provenance.current(), 1),
        pytest.raises(ResultsError, match="another run writes"),
    ):
        PartialResults(path, Provenance.current(), 1)
    PartialResults(path, Provenance.current(), 1).close()


def test_a_disk_without_space_for_the_results_is_told_before_the_run(tmp_path):
    with pytest.raises(ResultsError, match=r"MB left; the results may need"):
        PartialResults(tmp_path / "results.partial", Provenance.current(), 10**12)


def test_a_file_that_is_no_result_is_refused(tmp_path):
    (tmp_path / "no.parquet").write_text("no")
    with pytest.raises(ResultsError, match="cannot read results"):
        read_results(tmp_path / "no.parquet")
    table = pyarrow.table({"key": ["other"]})
    parquet.write_table(table, tmp_path / "other.parquet")
    with pytest.raises(ResultsError, match="does not contain results of wbc trials"):
        read_results(tmp_path / "other.parquet")


def test_a_file_without_a_column_that_was_added_later_is_read(results, tmp_path):
    table = results[0].to_arrow().drop_columns(["falling_at_s"])
    parquet.write_table(table, tmp_path / "old.parquet")
    rows = read_results(tmp_path / "old.parquet").rows
    assert rows == tuple(replace(row, falling_at_s=None) for row in results[0].rows)
