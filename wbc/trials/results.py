"""Results of a grid in Parquet, with the grid and the versions that they come from."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from types import NoneType
from typing import Any, get_args, get_type_hints

from wbc.errors import MissingExtra, did_you_mean
from wbc.trials.errors import ResultsError
from wbc.trials.grid import Grid
from wbc.trials.grid_file import grid_to_json, parse_grid
from wbc.trials.provenance import Provenance
from wbc.trials.result import UNDISTURBED, TrialResult

_METADATA = b"wbc.trials"


@dataclass(frozen=True)
class Results:
    """The results of a grid.

    Attributes:
        rows: one per trial and undisturbed run, in the order of the grid.
        grid: the grid.
        provenance: versions of the software that computed them.
    """

    rows: tuple[TrialResult, ...]
    grid: Grid
    provenance: Provenance

    def __repr__(self) -> str:
        return f"Results('{self.grid.name}', {len(self.trials)} trials, {len(self.runs)} runs)"

    @property
    def trials(self) -> tuple[TrialResult, ...]:
        """The results of the trials."""
        return tuple(row for row in self.rows if row.disturbance != UNDISTURBED)

    @property
    def runs(self) -> tuple[TrialResult, ...]:
        """The results of the undisturbed runs."""
        return tuple(row for row in self.rows if row.disturbance == UNDISTURBED)

    def of_controller(self, name: str) -> Results:
        """Return the results of one controller.

        Raises:
            ResultsError: there are none.
        """
        rows = tuple(row for row in self.rows if row.controller == name)
        if not rows:
            names = sorted({row.controller for row in self.rows})
            raise ResultsError(f"there are no results of '{name}'{did_you_mean(name, names)}")
        return replace(self, rows=rows)

    def to_arrow(self) -> Any:
        """Return a `pyarrow.Table`, whose metadata contain the grid and the versions.

        Raises:
            MissingExtra: `pyarrow` is not installed.
        """
        pyarrow = import_pyarrow()
        schema = pyarrow.schema(
            [pyarrow.field(name, *kind) for name, kind in _arrow_types(pyarrow).items()],
            metadata={_METADATA: self._metadata()},
        )
        return pyarrow.Table.from_pylist([asdict(row) for row in self.rows], schema=schema)

    def to_pandas(self) -> Any:
        """Return a `pandas.DataFrame`.

        Raises:
            ImportError: `pandas` is not installed.
        """
        return self.to_arrow().to_pandas()

    def write(self, path: str | Path) -> None:
        """Write a Parquet file; an existing one is replaced when the new one is complete.

        Raises:
            ResultsError: it cannot be written.
            MissingExtra: `pyarrow` is not installed.
        """
        import_pyarrow()
        from pyarrow import parquet

        path = Path(path)
        temporary = path.with_name(f"{path.name}.new")
        try:
            parquet.write_table(self.to_arrow(), temporary, compression="zstd")
            os.replace(temporary, path)
        except OSError as error:
            temporary.unlink(missing_ok=True)
            raise ResultsError(f"cannot write {path}: {error.strerror or error}") from error

    def _metadata(self) -> bytes:
        content = {
            "grid": json.loads(grid_to_json(self.grid)),
            "versions": asdict(self.provenance),
        }
        return json.dumps(content, sort_keys=True).encode()


def read_results(path: str | Path) -> Results:
    """Read the results that `run_grid` has written.

    Raises:
        ResultsError: the file cannot be read, or does not contain results of trials.
        MissingExtra: `pyarrow` is not installed.
    """
    pyarrow = import_pyarrow()
    from pyarrow import parquet

    try:
        table = parquet.read_table(Path(path))
    except (OSError, pyarrow.ArrowException) as error:
        raise ResultsError(f"cannot read results from {path}: {error}") from error
    try:
        content = json.loads((table.schema.metadata or {})[_METADATA])
        # Columns that have been added since are missing in files of earlier versions.
        rows = tuple(TrialResult(**row) for row in table.to_pylist())
        provenance = Provenance(**content["versions"])
    except (KeyError, ValueError, TypeError) as error:
        raise ResultsError(f"{path} does not contain results of wbc trials") from error
    return Results(rows, parse_grid(content["grid"], str(path)), provenance)


def in_grid_order(grid: Grid, rows: Sequence[TrialResult]) -> tuple[TrialResult, ...]:
    """Return those results that belong to a grid, in its order, named as it names them."""
    by_key = {row.key: row for row in rows}
    ordered = []
    for run in grid.runs():
        for key in (run.key, *(trial.key for trial in grid.trials(run))):
            row = by_key.get(key)
            if row is not None:
                ordered.append(row.renamed(run.controller.name, run.condition.name))
    return tuple(ordered)


def _arrow_types(pyarrow: Any) -> dict[str, tuple[Any, bool]]:
    """Return the Arrow type of each column, and whether it may be null."""
    types = {str: pyarrow.string(), bool: pyarrow.bool_(), int: pyarrow.int64()}
    types[float] = pyarrow.float64()
    columns = {}
    for name, hint in get_type_hints(TrialResult).items():
        kinds = get_args(hint) or (hint,)
        kind = next(k for k in kinds if k is not NoneType)
        columns[name] = (types[kind], NoneType in kinds)
    return columns


def import_pyarrow() -> Any:
    """Import and return the `pyarrow` module.

    Raises:
        MissingExtra: it is not installed.
    """
    try:
        import pyarrow
    except ImportError as error:
        raise MissingExtra("pyarrow", "trials") from error
    return pyarrow
