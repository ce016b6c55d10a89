"""`breastrig serve`: the service and its page, until Ctrl-C or SIGTERM."""

import argparse
import html
import logging
import os
import signal
import sys
import tempfile
import threading
import webbrowser
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from types import FrameType

from breastrig.api.app import create_app
from breastrig.api.config import TOKEN_VARIABLE, Config, checked_token
from breastrig.api.people.people import read_people
from breastrig.api.settings import token_source
from breastrig.api.web_server import Server, ServerLimits
from breastrig.archive.nodes import nodes_of
from breastrig.cli.interruption import NUMBERS, raise_if_asked
from breastrig.cli.options.service_options import add_service_options, service_settings
from breastrig.core.errors import BadSettings
from breastrig.core.log_lines import set_up_logs
from breastrig.core.notice import RESEARCH_USE_ONLY
from breastrig.execution.executor import Executor
from breastrig.execution.limits import FitLimits
from breastrig.service.service import Service
from breastrig.storage.storage import Storage
from breastrig.use.fit import run_fit

log = logging.getLogger(__name__)
add_options = add_service_options


def run(options: argparse.Namespace) -> int:
    """Serves until a signal stops it.  Raises BadSettings or BadModel when it cannot start."""
    found = service_settings(options)
    setting = {name: one.value for name, one in found.items()}
    set_up_logs(setting["log"])
    given, token_from = token_source(found)
    os.environ.pop(TOKEN_VARIABLE, None)  # it is known now; processes that are started later are not to inherit it
    people = None if setting["users"] is None else read_people(setting["users"])
    if people is not None and people.proxy_header is not None and setting["trusted_proxy"] is None:
        raise BadSettings("proxy_header believes what a proxy says; name its address with --trusted-proxy.")
    config = Config(
        host=setting["host"],
        token=checked_token(
            setting["host"],
            given,
            setting["trusted_proxy"],
            no_token=setting["no_token"],
            users=people is not None,
        ),
        people=people,
        trusted_proxy=setting["trusted_proxy"],
        public_hosts=setting["public_host"],
        model=setting["model"],
        keep_days=setting["keep_days"],
        archives={} if setting["archives"] is None else nodes_of(setting["archives"]),
        log_requests=setting["log_requests"] == "yes"
        or (setting["log_requests"] == "auto" and not sys.stderr.isatty()),
    )
    limits = FitLimits(workers=setting["workers"], waiting_per_client=setting["waiting_per_client"])
    if setting["scheduler"] is not None:
        log.warning("fits need workers on this machine, which see the data folder; `batch` takes any")
    storage = Storage(setting["data"])
    executor = None if setting["scheduler"] is None else _cluster(setting["scheduler"], limits)
    service = Service(
        storage,
        runner=run_fit,
        model=config.model,
        uploads=config.uploads,
        fits=limits,
        executor=executor,
        streams=config.streams,
        keep_days=config.keep_days,
    )
    with ExitStack() as stack:
        if executor is not None:
            stack.callback(executor.stop)
        app = create_app(config, service)
        server = Server(app.wsgi_app, config, setting["port"], service.end_streams, ServerLimits())
        stack.callback(server.close)
        with service.started():
            _stop_on_signals(server.stop)
            raise_if_asked()  # someone may have swallowed an interruption while the service started
            shown = f"[{config.host}]" if ":" in config.host else config.host
            address = f"http://{shown}:{server.effective_port}/"
            if people is not None:
                access = f"People sign in at {people.issuer or 'the proxy'}."
                access += "" if given is None else f" Scripts send the token ({token_from}) as a bearer."
            elif given is None and config.token is not None:
                address += f"?token={config.token}"
                access = "This address lets a browser in; scripts send the token in it as a bearer. Give it to nobody."
            elif config.token is not None:
                access = f"Browsers are asked for the token ({token_from}); scripts send it as a bearer."
            else:
                access = "No token: every user and program of this machine can read, change and delete all patients."
            print(f"BreastRig is ready: {address}   (Ctrl-C stops it)\n{access}\n{RESEARCH_USE_ONLY}", flush=True)
            if sys.stdout.isatty() and not setting["no_browser"]:
                _show(address, stack)
            server.run()
    return 0


def _show(address: str, stack: ExitStack) -> None:
    """Opens the address in a browser, where there is a display, by way of a file that only this user can read.

    The command line of a browser, which all users of the machine can read, so names no token.
    """
    if sys.platform != "darwin" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return
    page = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="breastrig-open-")), "open.html")
    page.write_text(f'<!doctype html><meta http-equiv="refresh" content="0; url={html.escape(address)}">')
    threading.Thread(target=webbrowser.open, args=(page.as_uri(),), daemon=True).start()  # some wait for the browser


def _cluster(address: str, limits: FitLimits) -> Executor:
    """The workers of a Dask scheduler.  Raises BadSettings when it does not answer or Dask is not installed."""
    from breastrig.execution.dask_pool import DaskPool  # most installations have no Dask

    return DaskPool(address, memory_bytes=limits.memory_bytes)


def _stop_on_signals(end: Callable[[], None]) -> None:
    """Until now a signal interrupted the start.  From now on the first one calls `end`, and later ones do not disturb
    the tidying up; one that is ignored (nohup, background) stays ignored."""

    def stop(_number: int, _frame: FrameType | None) -> None:
        for number in NUMBERS:
            signal.signal(number, signal.SIG_IGN)
        end()

    for number in NUMBERS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, stop)
