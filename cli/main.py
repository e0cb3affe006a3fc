"""The program: finds subcommands, and turns errors into one line and an exit code.

One file in this folder is one subcommand, named after the file; it offers ``command``. Help is read from the
files' docstrings, so that ``bpns --help`` imports none of them.
"""

import ast
import os
import sys
import warnings
from pathlib import Path

import click

from bpns import __version__
from bpns.symbolic.errors import InputError, Unsupported
from bpns.symbolic.plugins import PlugIns

BAD_INPUT, UNSUPPORTED, CODE_ERROR = 36, 37, 70


COMMANDS = PlugIns("command", "bpns.cli", "command")


class _Commands(click.Group):
    def list_commands(self, _: click.Context) -> list[str]:
        return COMMANDS.names()

    def get_command(self, context: click.Context, name: str) -> click.Command | None:
        if name not in self.list_commands(context):
            return None
        command: click.Command = COMMANDS.load(name)
        return command

    def format_commands(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        rows = []
        for name in self.list_commands(context):
            text = (Path(__file__).parent / f"{name}.py").read_text(encoding="utf-8")
            rows.append((name, (ast.get_docstring(ast.parse(text)) or "").partition("\n")[0]))
        with formatter.section("Commands"):
            formatter.write_dl(rows)


@click.command(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="bpns")
def program() -> None:
    """Learn skills from demonstrations, export them as PDDL, and plan with any planner.

    Exit codes: 0 done, 1 differences or faults found (replay, envs check, validate, diff), 2 wrong usage,
    11 no plan exists, 12 plans exist but none was refined within the limits, 32 the planner failed, 36 bad
    input, 37 unsupported PDDL, 70 an error in the code, mostly of an environment of one's own.
    """


def main() -> None:
    """Run the command line and exit."""
    warnings.showwarning = lambda message, *_, **__: print(f"warning: {message}", file=sys.stderr)
    try:
        program(prog_name="bpns")
    except InputError as error:
        print(f"error: {' '.join(str(error).split())}", file=sys.stderr)
        sys.exit(UNSUPPORTED if isinstance(error, Unsupported) else BAD_INPUT)
    except BrokenPipeError:
        sys.stderr.close()  # the reader has gone: say nothing more
        sys.exit(141)
    except OSError as error:
        print(f"error: {error.strerror or error}: {error.filename}", file=sys.stderr)
        sys.exit(BAD_INPUT)
    except Exception as error:
        if "BPNS_TRACEBACK" in os.environ:
            raise
        text = " ".join(f"{type(error).__name__}: {error}".split())
        advice = "'bpns envs check NAME' says what an environment lacks; BPNS_TRACEBACK=1 shows where it was"
        print(f"error: {text} ({advice})", file=sys.stderr)
        sys.exit(CODE_ERROR)
