"""The command line."""

from __future__ import annotations

import os
import sys

import click

from stiffkit.cli.commands import main as _group
from stiffkit.errors import StiffkitError


def main() -> None:
    """Run a command; what the user can mend ends with a message and status 2."""
    try:
        _group(prog_name="stiffkit", standalone_mode=False)
    except StiffkitError as error:
        click.echo(f"{click.style('error:', fg='red', bold=True)} {error}", err=True)
        sys.exit(2)
    except click.ClickException as error:
        error.show()
        sys.exit(error.exit_code)
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted; nothing was written", err=True)
        sys.exit(130)
    except BrokenPipeError:
        # The reader, such as head, has what it wanted.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


__all__ = ["main"]
