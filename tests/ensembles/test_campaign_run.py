"""Campaigns: the same bits however they are run, and nothing finished is ever lost."""

import errno
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import tvclin as tv
from tests.turns import usual
from tvclin.ensembles.campaign.campaign_plan import checkpoints
from tvclin.ensembles.campaign.cases import evaluate, nominal
from tvclin.ensembles.campaign.chunk_runner import damaged
from tvclin.ensembles.campaign.folder import (
    NAME,
    begin,
    check_versions,
    chunk_fault,
    chunk_file,
    new_manifest,
    read_manifest,
    write_chunk,
)
from tvclin.ensembles.campaign.outputs import REGISTRY, columns
from tvclin.kernels.choice import available, pinned

pytest.importorskip("pyarrow")

SPREAD = tv.Dispersions(
    (
        tv.Dispersion("thrust", "truncated", 0.02),
        tv.Dispersion("normal_force_slope", "normal", 0.05),
        tv.Dispersion("wind_duration", "uniform", 0.3),
    ),
    correlation=((1.0, 0.3, 0.0), (0.3, 1.0, 0.0), (0.0, 0.0, 1.0)),
)

LINES = 1e-3
"""Trim and demand meet on one of 64 straight lines: (beta T/64)^2/8, and T is 9 s at the most."""
FEW = ((1.0, 0.3), (0.3, 1.0))


@pytest.fixture(scope="module")
def plan():
    """Return a campaign at nominal pressure, which is quick; that encountered has its own case."""
    return tv.Campaign(
        vehicle=tv.load_vehicle("configuration-i"),
        wind=tv.ShapedWind("triangular", peak=np.radians(5), duration=7.5),
        dispersions=SPREAD,
        model="fixed-path",
        sign="frozen",
        outputs=("required", "minimum"),
        dead_bands=(1.0, 0.5),
        cases=700,
        chunk=128,
        seed=11,
        nozzle=tv.Nozzle(limit=np.radians(0.42)),
        probability=0.9,
    )


@pytest.fixture(scope="module")
def whole(plan, tmp_path_factory):
    return tv.run_campaign(plan, tmp_path_factory.mktemp("whole") / "results")


def same(first, second):
    names = (*first.campaign.dispersions.parameters, *first.outputs, "case", "status")
    for name in names:
        np.testing.assert_array_equal(first.column(name), second.column(name), err_msg=name)


@pytest.mark.thorough
@pytest.mark.parametrize("chunk", usual([97, 256, 700, 5000], 2))
def test_the_chunk_changes_no_bit(plan, whole, tmp_path, chunk):
    same(whole, tv.run_campaign(replace(plan, chunk=chunk), tmp_path))


@pytest.mark.thorough
@pytest.mark.parametrize("model", usual(["fixed-path", "drift-exact"], 1))
def test_a_case_alone_has_the_bits_that_it_has_in_company(plan, model):
    time = np.linspace(0.0, 20.0, 12)
    winds = 0.08 * np.sin(np.pi * time / 20.0) * np.linspace(0.2, 1.0, 9)[:, np.newaxis]
    nozzle = tv.Nozzle(limit=0.01, rate_limit=0.5, actuator=tv.Actuator(natural_frequency=20.0))
    outputs = ("required", "forecast-free", "minimum", "flight")
    for wind in (plan.wind, tv.winds.WindEnsemble(time, winds)):
        spread = SPREAD if wind is plan.wind else tv.Dispersions(SPREAD.distributions[:2], FEW)
        given = {"wind": wind, "dispersions": spread, "nozzle": nozzle, "cases": 48}
        request = replace(plan, model=model, sign=None, outputs=outputs, **given)
        with pinned(available()):  # as campaigns are
            whole = evaluate(request, 0, 48)
            for first, count in ((0, 1), (42, 1), (47, 1), (3, 7), (20, 20)):
                for name, values in evaluate(request, first, count).items():
                    np.testing.assert_array_equal(values, whole[name][first : first + count], name)


@pytest.mark.thorough
def test_damping_is_dispersed_by_its_name_and_every_case_is_that_of_a_single_study(plan):
    vehicle = plan.vehicle.replace(pitch_damping=0.05 * plan.vehicle.moment_of_inertia)
    nozzle = tv.Nozzle(limit=0.01, rate_limit=0.5, actuator=tv.Actuator(natural_frequency=20.0))
    request = replace(
        plan,
        vehicle=vehicle,
        sign=None,
        dispersions=tv.Dispersions((tv.Dispersion("pitch_damping", "normal", 0.6),)),
        outputs=("required", "forecast-free", "minimum", "flight"),
        nozzle=nozzle,
        cases=60,
    )
    result = evaluate(request, 0, 60)
    damping = result["pitch_damping"]
    impossible = damping < 0.0
    assert 0 < impossible.sum() < 20
    np.testing.assert_array_equal(result["status"] != "ok", impossible)
    for case in np.flatnonzero(~impossible)[:4]:
        study = tv.Study.from_vehicle(
            vehicle.replace(pitch_damping=float(damping[case])),
            **{"duration": 7.5, "peak": np.radians(5), "dead_band": 0.5, "model": "fixed-path"},
        )
        # With the worse sign of the wind, whose factor of a batch is within 5e-4.
        assert result["required_K0.5"][case] == pytest.approx(study.required_deflection, rel=5e-4)
        assert result["minimum"][case] == pytest.approx(study.minima["fixed-path"], rel=1e-12)
    order = np.argsort(damping[~impossible])
    assert np.all(np.diff(result["required_K1"][~impossible][order]) < 0.0)  # trim: less with more


def test_a_part_of_no_damping_is_refused(plan):
    part = tv.Dispersions((tv.Dispersion("pitch_damping", "normal", 0.3),))
    with pytest.raises(tv.InputError, match="pitch_damping"):
        tv.ensembles.disperse_study(
            tv.Study.from_vehicle(plan.vehicle, duration=7.5, peak=0.05, model="fixed-path"), part
        )


@pytest.mark.thorough
@pytest.mark.parametrize("method", usual(["sobol", "latin"], 1))
def test_other_ways_to_draw_do_not_know_the_chunk_either(plan, tmp_path, method):
    first, second = (
        tv.run_campaign(replace(plan, method=method, chunk=chunk), tmp_path / str(chunk))
        for chunk in (97, 700)
    )
    same(first, second)


def test_dead_bands_that_are_nearly_equal_have_names_of_their_own(plan):
    near = replace(plan, dead_bands=(0.5, 0.5 + 1e-9))
    assert len(columns(near)) == 3


def test_cases_are_those_of_single_studies(plan, whole):
    for case in (0, 255, 256, 699):
        drawn = {name: float(whole.column(name)[case]) for name in SPREAD.parameters}
        duration = drawn.pop("wind_duration")
        vehicle = plan.vehicle.replace(**drawn)
        encountered = evaluate(replace(plan, sign=None), case, 1)
        for K, name in ((1.0, "required_K1"), (0.5, "required_K0.5")):
            study = tv.Study.from_vehicle(
                vehicle, duration=duration, peak=np.radians(5), dead_band=K, model="fixed-path"
            )
            assert encountered[name] == pytest.approx(study.required_deflection, rel=LINES)
            computed = whole.column(name)[case]
            assert computed == pytest.approx(study.nominal_deflection, rel=1e-12)
        computed = whole.column("minimum")[case]
        assert computed == pytest.approx(study.minima["fixed-path"], rel=1e-12)


@pytest.mark.thorough
def test_an_executor_out_of_order_changes_no_bit(plan, whole, tmp_path):
    counts = []
    with ThreadPoolExecutor(3) as pool:
        results = tv.run_campaign(
            plan, tmp_path, executor=pool, progress=lambda *now: counts.append(now)
        )
    same(whole, results)
    assert counts[-1] == (700, 700)
    assert [done for done, _ in counts] == sorted(done for done, _ in counts)


@pytest.mark.thorough
def test_workers_are_told_the_whole_path(plan, whole, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    counts = []
    with ThreadPoolExecutor(1) as pool:
        submit = pool.submit

        def listening(function, folder, *rest):
            counts.append(folder)
            return submit(function, folder, *rest)

        monkeypatch.setattr(pool, "submit", listening)
        same(whole, tv.run_campaign(plan, "results", executor=pool))
    assert set(counts) == {str(tmp_path / "results")}


@pytest.mark.thorough
def test_shards_make_up_the_whole(plan, whole, tmp_path):
    parts = [tv.run_campaign(plan, tmp_path, shard=f"{i}/3") for i in (3, 1, 2)]
    assert [part.cases for part in parts] == [128 + 60, 3 * 128 + 60, 700]
    assert [part.complete for part in parts] == [False, False, True]
    same(whole, parts[-1])


@pytest.mark.thorough
def test_a_killed_run_goes_on_where_it_was(plan, whole, tmp_path):
    folder = tmp_path / "results"
    code = f"""
import time, tvclin as tv
from pathlib import Path
from tvclin.ensembles.campaign import chunk_runner as engine
from tvclin.ensembles.campaign.folder import read_manifest
plan = read_manifest(Path({str(whole.folder)!r})).campaign
inner = engine.run_chunk
def two(*arguments):
    while len(list(Path({str(folder)!r}).glob("chunks/0*.parquet"))) == 2:
        time.sleep(1.0)  # until it is killed
    return inner(*arguments)
engine.run_chunk = two
tv.run_campaign(plan, {str(folder)!r})
"""
    child = subprocess.Popen([sys.executable, "-c", code])
    while len(list(folder.glob("chunks/0*.parquet"))) < 2 and child.poll() is None:
        time.sleep(0.02)
    child.send_signal(signal.SIGKILL)
    child.wait()
    kept = {file: file.stat().st_mtime_ns for file in folder.glob("chunks/0*.parquet")}
    assert len(kept) == 2 < plan.chunks
    same(whole, tv.ensembles.resume_campaign(folder))
    assert all(file.stat().st_mtime_ns == then for file, then in kept.items())


@pytest.mark.thorough
@pytest.mark.parametrize("each", usual([101, 1], 0))
def test_any_flipped_bit_of_a_chunk_is_named_or_changes_nothing(plan, tmp_path, each):
    """Of values, footer and metadata alike, whichever columns are read."""
    whole = tv.run_campaign(replace(plan, cases=12, chunk=12), tmp_path)
    file, names = chunk_file(tmp_path, 0), (*SPREAD.parameters, *whole.outputs, "case", "status")
    good, before = file.read_bytes(), {name: whole.column(name) for name in names}
    named = 0
    for at in range(0, 8 * len(good), each):
        bad = bytearray(good)
        bad[at // 8] ^= 1 << (at % 8)
        file.write_bytes(bad)
        said, name = chunk_fault(tmp_path, whole.manifest, 0), names[at % len(names)]
        if said is None:
            read = whole.column(name)
            assert read.dtype == before[name].dtype
            np.testing.assert_array_equal(read, before[name])
            continue
        named += 1
        assert str(file) in said
        with pytest.raises(tv.InputError, match=re.escape(said)):
            whole.column(name)
    assert named > 0.7 * 8 * len(good) / each


def swapped(table):
    """Two columns under each other's names: as good as any to whoever looks at names alone."""
    names = table.column_names
    i, j = names.index("thrust"), names.index("required_K1")
    names[i], names[j] = names[j], names[i]
    return table.rename_columns(names).replace_schema_metadata(table.schema.metadata)


def of_bytes(table):
    """The status as bytes."""
    import pyarrow

    at = table.column_names.index("status")
    return table.set_column(at, "status", table["status"].cast(pyarrow.binary()))


def without_hash(table):
    """The metadata without the hash of the columns."""
    kept = {k: v for k, v in table.schema.metadata.items() if k != b"tvclin_content"}
    return table.replace_schema_metadata(kept)


def without_a_column(table):
    """All but one column."""
    return table.drop_columns(["required_K1"])


@pytest.mark.thorough
def test_what_a_footer_says_is_no_more_believed_than_the_numbers(plan, whole, tmp_path):
    import pyarrow.parquet

    shutil.copytree(whole.folder, folder := tmp_path / "results")
    damages = (swapped, of_bytes, without_hash, without_a_column)
    for chunk, damage in enumerate(damages):
        file = chunk_file(folder, chunk)
        pyarrow.parquet.write_table(damage(pyarrow.parquet.read_table(file)), file)
        result = replace(tv.ensembles.open_campaign(folder), chunks=(chunk,))
        for ask in (result.quantile, result.statuses, result.drivers, result.worst, result.success):
            with pytest.raises(tv.InputError, match=rf"{chunk}\.parquet is damaged.*it anew"):
                ask()
    faults = damaged(folder, read_manifest(folder))
    for chunk in range(len(damages)):
        assert f"{chunk}.parquet is damaged" in faults[chunk]
    tv.run_campaign(plan, folder)
    same(whole, tv.ensembles.open_campaign(folder))


@pytest.mark.thorough
def test_damaged_and_foreign_chunks_are_named_and_computed_anew(plan, whole, tmp_path):
    tv.run_campaign(plan, tmp_path)
    other = tv.run_campaign(replace(plan, seed=12), tmp_path / "other")
    short = chunk_file(tmp_path, 0)
    short.write_bytes(short.read_bytes()[:-100])
    chunk_file(tmp_path, 2).write_bytes(chunk_file(other.folder, 2).read_bytes())
    chunk_file(tmp_path, 3).write_bytes(chunk_file(tmp_path, 4).read_bytes())
    said = damaged(tmp_path, read_manifest(tmp_path))
    assert sorted(said) == [0, 2, 3]
    assert "00000000.parquet is damaged" in said[0]
    assert "is not chunk 2 of this campaign" in said[2]
    with pytest.raises(tv.InputError, match=r"00000000\.parquet is damaged; compute it anew"):
        tv.ensembles.open_campaign(tmp_path).quantile()
    same(whole, tv.ensembles.resume_campaign(tmp_path))


@pytest.mark.thorough
@pytest.mark.parametrize("what", usual(["folder", "full folder", "pipe"], 1))
def test_what_stands_in_the_place_of_a_chunk_is_moved_aside(plan, whole, tmp_path, what):
    tv.run_campaign(plan, tmp_path, shard="1/3")
    file = chunk_file(tmp_path, 0)
    file.unlink()
    os.mkfifo(file) if what == "pipe" else file.mkdir()
    if what == "full folder":
        (file / "of somebody").write_text("else")
    with pytest.raises(tv.InputError, match=r"00000000\.parquet is damaged; compute it anew"):
        tv.ensembles.open_campaign(tmp_path).quantile()
    same(whole, tv.ensembles.resume_campaign(tmp_path))
    (aside,) = file.parent.glob("00000000.parquet.*/00000000.parquet")
    assert not aside.is_file()
    if what == "full folder":
        assert (aside / "of somebody").read_text() == "else"


def test_a_folder_that_is_removed_while_it_is_worked_in_is_not_made_anew(plan, tmp_path):
    folder = tmp_path / "results"
    with pytest.raises(tv.InputError, match=r"results was removed, with its manifest, while"):
        tv.run_campaign(plan, folder, progress=lambda *_: shutil.rmtree(folder))
    assert not folder.exists()


@pytest.mark.thorough
@pytest.mark.parametrize(
    "damage", usual([lambda text: text[:50], lambda text: text.replace("11", "12")], 0)
)
def test_a_damaged_manifest_says_how_it_is_mended(plan, whole, tmp_path, damage):
    tv.run_campaign(plan, tmp_path)
    file, made = tmp_path / NAME, chunk_file(tmp_path, 0).stat().st_mtime_ns
    text = file.read_text()
    file.write_text(damage(text))
    with pytest.raises(tv.InputError, match="delete it and run the campaign file into this folder"):
        tv.ensembles.resume_campaign(tmp_path)
    file.unlink()
    same(whole, tv.run_campaign(plan, tmp_path))
    assert file.read_text() == text
    assert chunk_file(tmp_path, 0).stat().st_mtime_ns == made


@pytest.mark.thorough
def test_a_changed_manifest_is_refused(plan, tmp_path):
    tv.run_campaign(plan, tmp_path, shard="1/3")
    with pytest.raises(tv.InputError, match="holds another campaign, or this one before"):
        tv.run_campaign(replace(plan, seed=12), tmp_path)
    file = tmp_path / NAME
    text = file.read_text()
    file.write_text(text.replace('"seed": 11', '"seed": 12'))
    for attempt in (tv.ensembles.resume_campaign, tv.ensembles.open_campaign):
        with pytest.raises(tv.InputError, match="was changed after the campaign began"):
            attempt(tmp_path)
    file.write_text(text[:50])
    with pytest.raises(tv.InputError, match="is damaged: it is no manifest"):
        tv.ensembles.open_campaign(tmp_path)
    file.write_text(text)
    assert tv.ensembles.resume_campaign(tmp_path).complete


def test_other_versions_do_not_go_on(plan):
    manifest = new_manifest(plan, compiled=False)
    check_versions(manifest)
    old = replace(manifest, versions=manifest.versions | {"numpy": "1.0"})
    with pytest.raises(tv.InputError, match=r"was begun with numpy 1\.0, and here is"):
        check_versions(old)


def test_a_worker_without_a_compiler_refuses(plan, monkeypatch):
    monkeypatch.setattr("tvclin.ensembles.campaign.folder.available", lambda: False)
    compiled = replace(new_manifest(plan), versions=new_manifest(plan).versions | {"numba": "9"})
    with pytest.raises(tv.InputError, match=r"uses compiled kernels \(numba 9\).* install"):
        check_versions(compiled)


@pytest.mark.thorough
def test_a_full_disk_is_one_sentence_and_keeps_what_is_done(plan, whole, tmp_path, monkeypatch):
    import pyarrow.parquet

    inner, calls = pyarrow.parquet.write_table, []

    def full(table, target, **options):
        calls.append(target)
        inner(table, target, **options)
        if len(calls) > 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(pyarrow.parquet, "write_table", full)
        with pytest.raises(tv.InputError, match="cannot be written: No space left on device"):
            tv.run_campaign(plan, tmp_path)
    assert tv.ensembles.open_campaign(tmp_path).cases == 256
    assert len(list((tmp_path / "chunks").iterdir())) == 2  # no temporary file stays behind
    same(whole, tv.ensembles.resume_campaign(tmp_path))


@pytest.mark.thorough
def test_a_case_that_cannot_be_has_a_status_and_the_others_go_on(plan, tmp_path):
    wild = tv.Dispersions((tv.Dispersion("thrust", "normal", 0.6),))
    results = tv.run_campaign(replace(plan, dispersions=wild), tmp_path)
    bad = results.column("thrust") <= 0.0
    assert 0 < bad.sum() < 80
    np.testing.assert_array_equal(results.column("status") == "impossible vehicle or wind", bad)
    np.testing.assert_array_equal(np.isnan(results.column("required_K1")), bad)
    assert results.statuses() == {"ok": 700 - bad.sum(), "impossible vehicle or wind": bad.sum()}
    assert results.quantile().cases == 700 - bad.sum()


@pytest.mark.thorough
def test_a_case_that_fails_takes_no_other_with_it(plan, whole, tmp_path, monkeypatch):
    drawn = whole.column("thrust")
    inner = REGISTRY["required"]

    def work(campaign, batch):
        if np.any(np.isin(drawn[[5, 300]], wanted_thrust(batch))):
            raise ZeroDivisionError("nothing to divide by")
        return inner.work(campaign, batch)

    def wanted_thrust(batch):
        # mu_delta = T l_c / I: only the thrust differs between the cases.
        c, v = batch.plant.coefficients, plan.vehicle
        ratio = np.asarray(c.mu_delta) * v.moment_of_inertia / v.control_arm
        return drawn[np.abs(drawn[:, np.newaxis] / ratio - 1.0).min(axis=-1) < 1e-12]

    monkeypatch.setitem(REGISTRY, "required", replace(inner, work=work))
    results = tv.run_campaign(plan, tmp_path)
    status = results.column("status")
    assert np.flatnonzero(status != "ok").tolist() == [5, 300]
    assert set(status[[5, 300]]) == {"failed: nothing to divide by"}
    good = status == "ok"
    assert np.all(np.isnan(results.column("required_K1")[~good]))
    np.testing.assert_allclose(
        results.column("required_K1")[good], whole.column("required_K1")[good], rtol=1e-12
    )


def test_arrays_that_do_not_fit_are_no_fault_of_a_case(plan, monkeypatch):
    def work(campaign, batch):
        return {"required_K1": np.zeros(batch.count) + np.zeros(batch.count + 1)}

    monkeypatch.setitem(REGISTRY, "required", replace(REGISTRY["required"], work=work))
    with pytest.raises(ValueError, match="could not be broadcast"):
        evaluate(replace(plan, outputs=("required",)), 0, 8)


@pytest.mark.thorough
def test_a_dataset_has_every_column_with_its_unit(whole):
    pytest.importorskip("xarray")
    table = whole.to_xarray()
    assert dict(table.sizes) == {"case": 700}
    units = {name: table[name].attrs.get("units") for name in table.data_vars}
    drawn = {"thrust": "N", "normal_force_slope": "N/rad", "wind_duration": "s"}
    computed = {"required_K1": "rad", "required_K0.5": "rad", "minimum": "rad", "status": None}
    assert units == drawn | computed
    for name in units:
        np.testing.assert_array_equal(table[name].values, whole.column(name))


@pytest.mark.thorough
def test_a_stable_case_needs_nothing(plan, tmp_path):
    either = tv.Dispersions((tv.Dispersion("aerodynamic_arm", "normal", 1.0),))
    every = ("required", "minimum", "forecast-free")
    results = tv.run_campaign(replace(plan, dispersions=either, outputs=every), tmp_path)
    stable = results.column("aerodynamic_arm") <= 0.0
    np.testing.assert_array_equal(results.column("status") == "no unstable pole", stable)
    for name in results.outputs:
        np.testing.assert_array_equal(results.column(name) == 0.0, stable)


@pytest.mark.thorough
def test_it_stops_when_converged_and_at_the_same_place(plan, tmp_path):
    until = replace(plan, until=0.01, cases=20_000, chunk=64)
    first = tv.run_campaign(until, tmp_path / "one")
    assert first.converged
    assert first.complete
    assert 64 <= first.cases < 20_000
    bound = first.quantile()
    assert bound.upper - bound.lower <= 0.01 * bound.estimate
    ends = list(checkpoints(until.chunks))
    assert ends.index(len(first.chunks)) > 0
    earlier = replace(first, chunks=first.chunks[: ends[ends.index(len(first.chunks)) - 1]])
    assert not earlier.converged
    holed = replace(first, chunks=first.chunks[1:])
    assert not holed.converged
    with ThreadPoolExecutor(3) as pool:
        again = tv.run_campaign(until, tmp_path / "two", executor=pool)
    assert again.chunks == first.chunks
    assert tv.ensembles.resume_campaign(tmp_path / "two").chunks == first.chunks


def test_checkpoints_rise_to_the_end():
    for chunks in (1, 2, 11, 37, 1000):
        ends = list(checkpoints(chunks))
        assert ends == sorted(set(ends))
        assert ends[-1] == chunks
    assert len(list(checkpoints(100_000))) < 130


@pytest.mark.parametrize(
    ("shard", "message"),
    [("0/3", "i from 1 to n"), ("4/3", "i from 1 to n"), ("a", "must be i/n"), ("-1/3", "i/n")],
)
def test_a_shard_that_is_none(plan, tmp_path, shard, message):
    with pytest.raises(tv.InputError, match=message):
        tv.run_campaign(plan, tmp_path, shard=shard)


def test_a_shard_cannot_see_convergence(plan, tmp_path):
    until = replace(plan, until=0.1)
    for attempt in (
        lambda: tv.run_campaign(until, tmp_path, shard="1/2"),
        lambda: tv.ensembles.resume_campaign(tmp_path, shard="1/2"),
    ):
        with pytest.raises(
            tv.InputError, match="does not know when the whole campaign has converged"
        ):
            attempt()


def test_a_campaign_without_a_nominal_answer_does_not_begin(plan, tmp_path):
    slow = plan.vehicle.replace(velocity=150.0, aerodynamic_arm=1.0)  # its two poles are a pair
    without = replace(plan, vehicle=slow, model="drift-exact", outputs=("forecast-free",))
    with pytest.raises(tv.InputError, match="it has the complex pair"):
        tv.run_campaign(without, tmp_path / "results")
    assert not (tmp_path / "results").exists()


def test_the_nominal_case_is_that_of_the_study(plan, whole):
    study = tv.Study.from_vehicle(
        plan.vehicle, duration=7.5, peak=np.radians(5), model="fixed-path"
    )
    encountered = nominal(replace(plan, sign=None))["required_K1"]
    assert encountered == pytest.approx(study.required_deflection, rel=LINES)
    assert whole.nominal["required_K1"] == pytest.approx(study.nominal_deflection, rel=1e-12)


def test_nothing_finished_yet_is_one_sentence(plan, tmp_path):
    begin(plan, tmp_path)
    results = tv.ensembles.open_campaign(tmp_path)
    assert (results.cases, results.complete, results.statuses()) == (0, False, {})
    with pytest.raises(tv.InputError, match="there is no finished case with an answer"):
        results.quantile()


def test_what_killed_workers_left_is_swept_away_when_it_is_old(plan, tmp_path):
    tv.run_campaign(plan, tmp_path, shard="1/6")
    old, young = (tmp_path / "chunks" / f".0000000{k}.parquet.abc" for k in (3, 4))
    for file in (old, young):
        file.write_text("half")
    os.utime(old, (time.time() - 7200, time.time() - 7200))
    tv.ensembles.resume_campaign(tmp_path, shard="1/6")
    assert not old.exists()
    assert young.exists()


def test_without_pyarrow_the_extra_is_named_and_nothing_is_begun(plan, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(tv.InputError, match=r"need pyarrow, .*install .tvclin\[campaign\]"):
        tv.run_campaign(plan, tmp_path / "results")
    assert not list(tmp_path.iterdir())


def test_a_folder_without_a_campaign(tmp_path):
    with pytest.raises(tv.InputError, match="holds no campaign"):
        tv.ensembles.open_campaign(tmp_path)
    file = Path(tmp_path / "file")
    file.write_text("")
    with pytest.raises(tv.InputError, match="holds no campaign"):
        tv.ensembles.resume_campaign(file)


@pytest.mark.thorough
def test_statistics_of_a_million_cases_take_less_than_a_gibibyte(plan, tmp_path):
    if not Path("/proc/self/status").exists():
        pytest.skip("needs Linux, which tells the most memory of a process without its parent's")
    million = replace(plan, cases=2**20, chunk=2**15, outputs=("required",), dead_bands=(1.0,))
    manifest = begin(million, tmp_path, compiled=False)
    rng = np.random.default_rng(3)
    for k in range(million.chunks):
        first, count = million.span(k)
        drawn = {name: rng.normal(size=count) for name in SPREAD.parameters}
        answer = 3.0 * drawn["wind_duration"] - drawn["thrust"]
        row = {"case": np.arange(first, first + count), **drawn, "required_K1": answer}
        write_chunk(tmp_path, manifest, k, row | {"status": np.full(count, "ok", dtype=object)})
    code = f"""
import tvclin as tv
campaign = tv.ensembles.open_campaign({str(tmp_path)!r})
print(campaign.cases, campaign.quantile().estimate, list(campaign.drivers())[:2],
      len(campaign.worst(5)), campaign.statuses(), len(campaign.convergence()), sep="|")
print(next(x for x in open("/proc/self/status") if x.startswith("VmHWM")).split()[1])
"""
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    said, used = out.stdout.split("\n")[:2]
    cases, estimate, drivers, *others = said.split("|")
    assert cases == "1048576"
    # A normal number of variance 10: its 0.9 quantile is 1.2816 times the root of ten.
    assert float(estimate) == pytest.approx(1.2815515655 * np.sqrt(10.0), rel=5e-3)
    assert drivers == "['wind_duration', 'thrust']"
    assert others == ["5", "{'ok': 1048576}", "5"]
    assert int(used) * 1024 < 2**30
