"""Campaigns on processes and on a Dask cluster, of which one is killed midway."""

import multiprocessing
import os
import re
import signal
import socket
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tvclin.cli.app import app
from tvclin.ensembles.campaign.chunk_runner import cluster, processes

pytest.importorskip("pyarrow")


@pytest.fixture(scope="module")
def plan():
    return tv.Campaign(
        vehicle=tv.load_vehicle("configuration-i"),
        wind=tv.ShapedWind("triangular", peak=np.radians(5), duration=7.5),
        model="drift",
        cases=10 * 256,
        chunk=256,
        dead_bands=(0.5,),
        probability=0.9,
    )


@pytest.fixture(scope="module")
def whole(plan, tmp_path_factory):
    return tv.run_campaign(plan, tmp_path_factory.mktemp("whole"))


def same(first, second):
    assert second.complete
    for name in (*first.campaign.dispersions.parameters, *first.outputs, "case", "status"):
        np.testing.assert_array_equal(first.column(name), second.column(name), err_msg=name)


@pytest.mark.thorough
def test_a_killed_process_is_one_sentence_and_the_others_have_done_their_part(
    plan, whole, tmp_path
):
    killed = []

    def kill_one(done, total):
        del total
        if done >= 2 * 256 and not killed:
            killed.append(multiprocessing.active_children()[0].pid)
            os.kill(killed[0], signal.SIGKILL)

    with (
        pytest.raises(tv.InputError, match=r"a worker process has died .* run it again into"),
        processes(2) as pool,
    ):
        tv.run_campaign(plan, tmp_path, executor=pool, progress=kill_one)
    assert 2 * 256 <= tv.ensembles.open_campaign(tmp_path).cases < plan.cases
    with processes(1) as pool:
        same(whole, tv.ensembles.resume_campaign(tmp_path, executor=pool))


@pytest.mark.thorough
def test_a_cluster_loses_a_worker_and_nothing_else(plan, whole, tmp_path):
    distributed = pytest.importorskip("distributed")
    killed = []
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as local:

        def kill_one(done, total):
            del total
            if done >= 2 * 256 and not killed:
                killed.append(next(iter(local.workers.values())).pid)
                os.kill(killed[0], signal.SIGKILL)

        with cluster(local.scheduler_address) as executor:
            results = tv.run_campaign(plan, tmp_path, executor=executor, progress=kill_one)
    assert killed
    same(whole, results)


@pytest.mark.thorough
def test_a_scheduler_that_is_not_there(plan, tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("tvclin.ensembles.campaign.chunk_runner._TIMEOUT", 0.5)
    file = tmp_path / "my.toml"
    CliRunner().invoke(app, ["init", "--campaign", str(file)])
    arguments = ["disperse", str(file), "-o", str(tmp_path / "results")]
    result = CliRunner().invoke(app, [*arguments, "--scheduler", "tcp://127.0.0.1:1"])
    assert result.exit_code == 2
    assert "Error: there is no Dask scheduler at tcp://127.0.0.1:1" in result.stderr
    result = CliRunner().invoke(app, [*arguments, "--scheduler", "nonsense", "--workers", "2"])
    assert result.exit_code == 2
    assert "give --workers or --scheduler, not both" in result.stderr


@pytest.mark.thorough
def test_a_scheduler_that_is_not_there_leaves_no_client_that_closes_for_ten_seconds(monkeypatch):
    """A `Client` that could not connect waits as it is deleted, and prints what it fails with."""
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr("tvclin.ensembles.campaign.chunk_runner._TIMEOUT", 0.2)
    monkeypatch.setattr(distributed, "Client", pytest.fail)
    with socket.create_server(("127.0.0.1", 0)) as silent:  # takes connections and says nothing
        for port, reason in (
            (1, "(Timed out|no answer)"),
            (silent.getsockname()[1], "no answer after 0.2 s"),
        ):
            address = f"tcp://127.0.0.1:{port}"
            with pytest.raises(tv.InputError, match=f"at {address}: {reason}"), cluster(address):
                pass


@pytest.mark.thorough
@pytest.mark.skipif(os.name != "posix", reason="the signal masks of POSIX")
@pytest.mark.parametrize(
    "seconds", [0.7, *(pytest.param(one, marks=pytest.mark.thorough) for one in (0.0, 0.3, 1.5))]
)
def test_control_c_while_workers_start_prints_no_traceback(tmp_path, seconds):
    """The signal goes to all processes of a terminal, as here."""
    file = tmp_path / "interrupted.py"
    file.write_text(
        "import os, signal\n"
        "from time import sleep\n"
        "from tvclin.ensembles.campaign.chunk_runner import processes\n"
        "if __name__ == '__main__':\n"
        "    signal.signal(signal.SIGINT, signal.default_int_handler)  # a job may ignore it\n"
        "    try:\n"
        "        with processes(2) as pool:\n"
        "            calls = [pool.submit(sleep, 0.1) for _ in range(4)]\n"
        f"            sleep({seconds})\n"
        "            os.killpg(os.getpgrp(), signal.SIGINT)\n"
        "            sleep(60)\n"
        "    except KeyboardInterrupt:\n"
        "        print('stopped')\n"
    )
    done = subprocess.run(
        [sys.executable, file], capture_output=True, text=True, check=True, start_new_session=True
    )
    assert (done.stdout, done.stderr) == ("stopped\n", "")


@pytest.mark.thorough
def test_the_command_line_runs_on_workers(tmp_path):
    file = tmp_path / "my.toml"
    CliRunner().invoke(app, ["init", "--campaign", str(file)])
    file.write_text(file.read_text().replace("cases = 4096 ", "cases = 300 "))
    for folder, more in (("one", []), ("two", ["--workers", "2"])):
        arguments = ["disperse", str(file), "-o", str(tmp_path / folder), *more]
        assert CliRunner().invoke(app, arguments).exit_code == 1
    same(*(tv.ensembles.open_campaign(tmp_path / folder) for folder in ("one", "two")))


def test_without_distributed_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with (
        pytest.raises(tv.InputError, match=r"needs distributed, .*install .tvclin\[campaign\]"),
        cluster("tcp://127.0.0.1:1"),
    ):
        pass


@pytest.mark.parametrize("workers", [0, -1, 1.5, 10**9])
def test_a_number_of_workers_that_is_none(workers):
    with pytest.raises(tv.InputError, match="workers must be"), processes(workers):
        pass


def test_a_worker_of_another_version_refuses_before_it_writes(plan, tmp_path, monkeypatch):
    from tvclin.ensembles.campaign import folder as manifest
    from tvclin.ensembles.campaign.folder import run_chunk

    seal = manifest.begin(replace(plan, seed=4), tmp_path).seal
    monkeypatch.setattr(manifest, "version", lambda name: "99.0")
    with pytest.raises(tv.InputError, match=r"was begun with tvclin .*, and here is 99\.0"):
        run_chunk(str(tmp_path), seal, 0)
    with pytest.raises(tv.InputError, match="holds another campaign now"):
        run_chunk(str(tmp_path), "0" * 64, 0)
    assert not (tmp_path / "chunks").exists()


@pytest.mark.thorough
@pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="children are listed on Linux alone"
)
@pytest.mark.parametrize("whom", ["children", "parent"])
def test_whoever_is_killed_nothing_is_left_and_no_tracker_complains(tmp_path, whom):
    """The tracker of semaphores is a child as well; a new one knows none of them."""
    file, folder = tmp_path / "my.toml", tmp_path / "results"
    CliRunner().invoke(app, ["init", "--campaign", str(file)])
    file.write_text(re.sub(r"(?m)^cases = \d+", "cases = 400000", file.read_text()))
    command = [sys.executable, "-m", "tvclin", "disperse", file, "-o", folder]
    with subprocess.Popen(
        [*command, "--workers", "2"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as run:
        while run.poll() is None and not list(folder.glob("chunks/*.parquet")):
            time.sleep(0.1)
        children = Path(f"/proc/{run.pid}/task/{run.pid}/children").read_text().split()
        for pid in children if whom == "children" else [run.pid]:
            os.kill(int(pid), signal.SIGKILL)
        said, _ = run.communicate(timeout=600.0)  # the workers hold the pipe as long as they live
    assert len(children) == 3
    assert "Traceback" not in said
    assert "KeyError" not in said
    if whom == "children":
        assert run.returncode == 2
        progress, error, _ = said.partition("Error: a worker process has died")  # in several lines
        assert all(line.endswith(" cases") for line in progress.split("\n")[:-1])  # after 2 s
        assert error
