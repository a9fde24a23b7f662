"""``percuss serve``: the workbench, a page on this machine."""

from __future__ import annotations

import argparse
import os
import re
import secrets
from importlib import import_module

from percuss.cli.arguments import Parser, command, named_case, need, option, whole

_LEAST_TOKEN = 12
_VARIABLE = "PERCUSS_TOKEN"


def _host(text: str) -> str:
    if not re.fullmatch(r"[\w.:%\[\]-]+", text):
        raise argparse.ArgumentTypeError(f"'{text}': give a name or an address, such as 127.0.0.1, without a port")
    return text


def _token(text: str) -> str:
    if not re.fullmatch(r"[A-Za-z0-9._~-]*", text) or len(text) < _LEAST_TOKEN:
        accepted = f"{_LEAST_TOKEN} or more letters, digits and - . _ ~"
        raise argparse.ArgumentTypeError(f"give {accepted}, for example {secrets.token_urlsafe(16)}")
    return text


def _token_in(path: str) -> str:
    try:
        with open(path, encoding="utf-8") as file:
            line = file.readline(10_000).strip()
    except (OSError, ValueError) as error:
        raise argparse.ArgumentTypeError(f"cannot read {path}: {getattr(error, 'strerror', None) or error}") from None
    try:
        return _token(line)
    except argparse.ArgumentTypeError as error:
        raise argparse.ArgumentTypeError(f"the first line of {path} is not a token: {error}") from None


def _token_of(options: argparse.Namespace, parser: Parser) -> str:
    """The secret: from the file, the command line or the environment; "" for none."""
    if options.token and options.token_file:
        parser.error("arguments --token and --token-file: give only one of them")
    given = options.token_file or options.token
    if given is None and os.environ.get(_VARIABLE):
        try:
            given = _token(os.environ[_VARIABLE])
        except argparse.ArgumentTypeError as error:
            parser.error(f"environment variable {_VARIABLE}: {error}")
    return given or ""


def _origin(text: str) -> str:
    """An origin: scheme, host and maybe a port, nothing that could be another word of a header."""
    if not re.fullmatch(r"https?://[A-Za-z0-9.\-\[\]:]+", text):
        raise argparse.ArgumentTypeError(f"expected an origin such as https://school.example, got '{text}'")
    return text


@command(
    """\
The workbench: a page in the browser where a slider shows at once whether a hammer runs, where it stands on its
stability map, how the bar moves, and what each blow delivers. Everything is computed on this machine; no other
server is contacted. Only this machine can open the page unless --host says otherwise.""",
    """\
  percuss serve
  percuss serve breaker.toml
  percuss serve --host 0.0.0.0 --token-file ~/percuss.token --workers 4""",
    option("CASE", "the case that the page opens with: a TOML file, or a machine's name", nargs="?"),
    option("--host HOST", "address to listen on (default 127.0.0.1: this machine alone)", _host, default="127.0.0.1"),
    option("--port PORT", "port to listen on, 0 for any free one (default 8321)", whole(0, 65535), default=8321),
    option("--workers N", "processes (default 1)", whole(1, 256), default=1),
    option(
        "--seconds S", "after which an answer that takes longer is given up (default 30)", whole(1, 86400), default=30
    ),
    option(
        "--token-file FILE",
        "a file whose first line is a secret that the page must send; needed when --host admits other machines. "
        f"Without this option the secret is taken from the environment variable {_VARIABLE}",
        _token_in,
    ),
    option("--token TOKEN", "the secret itself; everybody on this machine can see it in the list of processes", _token),
    option(
        "--name NAME", "another name of this server, for use behind a reverse proxy", _host, action="append", default=[]
    ),
    option(
        "--embed ORIGIN",
        "a page elsewhere that may show this one within a frame, such as https://school.example",
        _origin,
        action="append",
        default=[],
    ),
    option("--no-browser", "do not open the page in the browser"),
)
def serve(parser: Parser, options: argparse.Namespace) -> int:
    """Serve the page until Ctrl-C."""
    need("web", "fastapi", "uvicorn", "httptools")
    # cli and web are rooms of one floor, which do not import each other: this is the one door between them
    settings_room = import_module("percuss.web.settings")
    token = _token_of(options, parser)
    if not settings_room.is_loopback(options.host) and not token:
        word = f"{_VARIABLE}={secrets.token_urlsafe(16)}"
        parser.error(
            f"argument --host: others can reach {options.host}: it needs a token, by --token-file FILE or in the "
            f"environment, such as {word}"
        )
    text = ""
    if options.case is not None:
        from percuss.case.case import without_files

        case = named_case(options.case)
        _ = case.hammer  # refused here, not first by the page
        text = without_files(case).to_toml()
    settings = settings_room.Settings(
        host=options.host, port=options.port, token=token, names=tuple(options.name), case=text,
        embed=tuple(options.embed),
        limits=settings_room.Limits(seconds=float(options.seconds)),
    )  # fmt: skip
    import_module("percuss.web.serving").serve(settings, options.workers, not options.no_browser)
    return 0
