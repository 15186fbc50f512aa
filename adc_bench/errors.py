"""Every error a user can cause: one family, each member with its exit code and the same four lines of text."""


class AdcBenchError(Exception):
    """An error told to the user as one block: where, what was found, what was wanted, what to do.

    Attributes:
        exit_code: the process' exit status when the error reaches the command line.
    """

    exit_code = 1

    def __init__(self, *, where: str, found: str, wanted: str, todo: str) -> None:
        self.where, self.found, self.wanted, self.todo = where, found, wanted, todo
        super().__init__(str(self))

    def __str__(self) -> str:
        rows = (
            ("where", self.where),
            ("found", self.found),
            ("wanted", self.wanted),
            ("what to do", self.todo),
        )
        return "\n".join(f"  {name + ':':<12}{text}" for name, text in rows)


class UsageError(AdcBenchError):
    """The command line asks for something that does not fit together."""

    exit_code = 2


class InputError(AdcBenchError):
    """A file, split, dataset, weights or submission that cannot be used."""

    exit_code = 3


class MachineError(AdcBenchError):
    """This machine lacks something that the work needs."""

    exit_code = 4
