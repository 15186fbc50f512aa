"""`adc-bench hide`: a hidden suite's file, to be published before anyone is scored on it."""

from pathlib import Path
from typing import Annotated

import typer

from adc_bench.errors import InputError


def hide(
    suite: Annotated[str, typer.Argument(help="An open suite's name (splits/suites/NAME.toml) or its file's path.")],
    out: Annotated[Path, typer.Option(help="The hidden suite's file, NAME.toml: it is called NAME.")],
    salt_file: Annotated[Path | None, typer.Option(help="The secret; or ADC_BENCH_SALT in the environment.")] = None,
) -> None:
    """Write a copy of a suite whose arenas follow from a secret, of which it tells the digest alone."""
    from adc_bench.evaluate.hidden_suite import hide_suite
    from adc_bench.world.salt import VARIABLE, load_salt

    salt = load_salt(salt_file)
    if salt is None:
        raise InputError(
            where="adc-bench hide",
            found="no salt",
            wanted="a secret of 16 bytes or more",
            todo=f"make one (openssl rand -hex 32 >salt.txt) and name it with --salt-file, or set {VARIABLE}",
        )
    typer.echo(f"{out}: suite {out.stem}, salt sha256 {hide_suite(suite, salt, out)}")
