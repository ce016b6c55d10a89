"""`breastrig serve`: the service and its page, until Ctrl-C or SIGTERM."""

import argparse
import logging
import signal
import sys
from pathlib import Path
from types import FrameType
from typing import Any

from breastrig.api.app import create_app
from breastrig.api.config import TOKEN_VARIABLE, Config, read_token
from breastrig.api.wsgi_server import listen
from breastrig.cli.data_option import add_data_option, data_folder
from breastrig.cli.purge_command import days
from breastrig.core.notice import RESEARCH_USE_ONLY
from breastrig.jobs.carry_out import Runner
from breastrig.jobs.run_fit import run_fit
from breastrig.jobs.service import Service
from breastrig.jobs.sweep import KEEP_DAYS
from breastrig.storage.storage import Storage

PORT = 8321


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("serve", help="serve the page and the HTTP API", description=__doc__)
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        help=f"address to listen on (default %(default)s); any but this machine's own needs {TOKEN_VARIABLE}",
    )
    parser.add_argument(
        "--port", type=_port, default=PORT, help="port to listen on (default %(default)s; 0: a free one)"
    )
    add_data_option(parser)
    parser.add_argument(
        "--keep-days",
        type=_days_or_forever,
        default=float(KEEP_DAYS),
        metavar="DAYS",
        help=f"delete scans so many days after their upload (default {KEEP_DAYS}), or: forever",
    )
    parser.add_argument("--model", type=Path, metavar="GLB", help="another rig than the package's torso")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Serves until it is told to stop.  Raises BadSettings or BadModel when it cannot start."""
    return serve(options, run_fit)


def serve(options: argparse.Namespace, runner: Runner) -> int:
    """The same with another way to carry out a fit."""
    logging.basicConfig(stream=sys.stderr, level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
    for noisy in ("waitress", "waitress.queue", "trimesh", "PIL"):
        logging.getLogger(noisy).setLevel(logging.ERROR)
    config = Config(host=options.host, token=read_token(options.host), model=options.model, keep_days=options.keep_days)
    service = Service(
        Storage(data_folder(options)),
        runner=runner,
        model=config.model,
        uploads=config.uploads,
        streams=config.streams,
        keep_days=config.keep_days,
    )
    app = create_app(config, service)
    server = listen(app, options.host, options.port, config.uploads.file_bytes)
    try:
        with service.started():
            _stop_on_signals(service)
            shown = f"[{options.host}]" if ":" in options.host else options.host
            print(f"BreastRig is ready: http://{shown}:{server.effective_port}/   (Ctrl-C stops it)", flush=True)
            print(RESEARCH_USE_ONLY, flush=True)
            if config.token is not None:
                print(f"Browsers are asked for the token of {TOKEN_VARIABLE}; scripts send it as a bearer.", flush=True)
            server.run()
    finally:
        server.task_dispatcher.shutdown()
        server.close()
    return 0


def _stop_on_signals(service: Service) -> None:
    """The first signal ends the streams and leaves the server's loop; later ones do not disturb the tidying up."""

    def stop(_number: int, _frame: FrameType | None) -> Any:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)
        service.end_streams()
        sys.exit(0)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, stop)


def _port(text: str) -> int:
    if not (text.isascii() and text.isdigit() and int(text) < 65536):
        raise argparse.ArgumentTypeError(f"{text} is not a port; use a number from 0 to 65535")
    return int(text)


def _days_or_forever(text: str) -> float | None:
    if text == "forever":
        return None
    value = days(text)
    if value == 0.0:
        raise argparse.ArgumentTypeError("0 days would delete each scan at once; use a longer time, or forever")
    return value
