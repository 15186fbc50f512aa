"""`adc-bench validate`: what is wrong with a submission, told before it is scored."""

from typing import TYPE_CHECKING, Annotated

import typer

from adc_bench.errors import InputError

if TYPE_CHECKING:
    from adc_bench.evaluate.validate import Check


def validate(
    submission: Annotated[str, typer.Argument(help="A folder with submission.toml, or a built-in driver's name.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
) -> None:
    """Load a submission and try it a few seconds under scoring limits; say all that would go wrong."""
    from adc_bench.evaluate.validate import validate as checks_of

    checks = []
    for check in checks_of(submission):
        checks.append(check)
        if not as_json:
            typer.echo(_line(check))
    if as_json:
        import msgspec

        typer.echo(msgspec.json.format(msgspec.json.encode(checks), indent=2).decode())
    if any(check.counts and not check.ok for check in checks):
        raise typer.Exit(InputError.exit_code)


def _line(check: "Check") -> str:
    mark = "ok" if check.ok else "FAULT" if check.counts else "note"
    rows = [(mark, check.name, check.found), *(("", name, text) for name, text in _help(check) if text)]
    return "\n".join(f"{mark:<6} {name:<11} {_indented(text)}" for mark, name, text in rows)


def _help(check: "Check") -> tuple[tuple[str, str], ...]:
    return (("  wanted", check.wanted), ("  to do", check.todo))


def _indented(text: str) -> str:
    return text.replace("\n", "\n" + " " * 19)
