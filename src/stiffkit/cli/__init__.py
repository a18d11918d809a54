"""The command line."""

from __future__ import annotations

import os
import signal
import sys
from typing import NoReturn

import click

from stiffkit.cli.commands import main as _group
from stiffkit.errors import StiffkitError


def main() -> None:
    """Run a command; what the user can mend ends with a message and status 2."""
    # As an interruption does, an order to end leaves no half-made results behind.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    try:
        _group(prog_name="stiffkit", standalone_mode=False)
    except StiffkitError as error:
        _fail(error)
    except click.ClickException as error:
        error.show()
        sys.exit(error.exit_code)
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted; nothing was written", err=True)
        sys.exit(130)
    except BrokenPipeError:
        # The reader, such as head, has what it wanted.
        _drop_output()
    except MemoryError:
        _fail(StiffkitError("this takes more memory than there is", mend="ask for fewer --points"))
    except OSError as error:
        _drop_output()
        _fail(StiffkitError(f"the output cannot be written: {error.strerror or error}"))


def _fail(error: StiffkitError) -> NoReturn:
    click.echo(f"{click.style('error:', fg='red', bold=True)} {error}", err=True)
    sys.exit(2)


def _drop_output() -> None:
    """Keep Python from failing once more when it ends and writes what is left."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


__all__ = ["main"]
