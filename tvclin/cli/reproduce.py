"""`tvclin reproduce`: the report's figures, their numbers, and the ledger, in a directory."""

from pathlib import Path
from typing import Annotated

import typer


def reproduce(
    output: Annotated[
        Path, typer.Option(help="Directory for the files; made if it is missing.")
    ] = Path("reproduced"),
) -> None:
    """Write the report's figures (PNG), their numbers (CSV), and the ledger (ledger.md)."""
    from tvclin.reproduce.figures import reproduce as write_everything

    written = write_everything(output)
    for path in written:
        typer.echo(str(path))
    typer.echo(f"Wrote {len(written)} files into {output}.")
