"""Results: access by name, statistics, files that come back as they were, and runs that go on where one ended."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
import xarray

from fowtlib.language.errors import ModelError, NotFoundError, SimulationError
from fowtlib.solving.results import Observer, RawTrajectory, Result, parameter_hash

PARAMETERS = {"body.mass": 2.5, "spring.stiffness": [1.0, 2.0]}


def raw_from(time: np.ndarray) -> RawTrajectory:
    x = np.column_stack([np.sin(time), np.cos(time)])
    return RawTrajectory(
        time,
        x,
        z=x[:, :1] ** 2,
        d=np.zeros((time.size, 0)),
        x_names=("body.x", "body.v"),
        z_names=("body.f",),
        parameter_hash=parameter_hash(PARAMETERS),
    )


def result_from(begin: float = 0.0, end: float = 10.0, *, observe: bool = False) -> Result:
    time = np.linspace(begin, end, round((end - begin) / 0.1) + 1)
    raw = raw_from(time)
    observer = Observer(
        lambda names: np.column_stack([raw.x[:, ["body.x", "body.v"].index(name)] for name in names]),
        lambda name: ("m/s", f"velocity {name}"),
        ("body.x", "body.v"),
    )
    return Result(
        time,
        {"surge": np.sin(time), "line.force": np.outer(time, [1.0, 2.0, 3.0]), "turns": np.ones((time.size, 2, 2))},
        {"surge": "m", "line.force": "N"},
        {"surge": "surge of the platform"},
        {"model": "pendulum", "title": "a pendulum", "solver": "idas", "tolerance": 1e-6, "parameters": PARAMETERS},
        raw,
        observer if observe else None,
    )


def test_a_result_is_a_labelled_series():
    surge = result_from()["surge"]
    assert isinstance(surge, xarray.DataArray)
    assert surge.attrs == {"units": "m", "long_name": "surge of the platform"}
    assert surge.dims == ("time",) and surge.time.attrs["units"] == "s"
    np.testing.assert_array_equal(surge.sel(time=10.0), np.sin(10.0))


def test_elements_of_vectors_and_matrices():
    result = result_from()
    np.testing.assert_array_equal(result["line.force[2]"], 3.0 * result.time)
    assert result["line.force[2]"].attrs["units"] == "N"
    assert result["turns[0,1]"].shape == result.time.shape
    assert list(result.to_pandas().columns)[:2] == ["surge", "line.force[0]"]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("srge", "there is no result 'srge'; did you mean 'surge'?"),
        (
            "q",
            "there is no result 'q'; there are 'surge', 'line.force' and 'turns'. "
            "Other variables of the model can be asked for after Result.open(path, plant=plant).",
        ),
        ("line.force[3]", "there is no 'line.force[3]': the result 'line.force' has 3 elements, counted from 0."),
        ("surge[0]", "there is no 'surge[0]': the result 'surge' is a single number."),
    ],
)
def test_unknown_name(name, message):
    with pytest.raises(NotFoundError) as caught:
        result_from()[name]
    assert str(caught.value) == message


def test_any_variable_of_the_model_can_be_observed():
    result = result_from(observe=True)
    np.testing.assert_array_equal(result["body.v"], np.cos(result.time))
    assert result["body.v"].attrs == {"units": "m/s", "long_name": "velocity body.v"}
    with pytest.raises(NotFoundError, match=r"^there is no result 'body.w'; did you mean 'body.[vx]'"):
        result["body.w"]
    assert "body.v" not in result and "body.v" in result.keep("body.v")


def test_a_bare_function_observes_too():
    result = result_from()
    result.attach(lambda names: np.ones((result.time.size, len(names))))
    assert result["anything"].values.tolist() == [1.0] * result.time.size


def test_statistics_without_the_beginning():
    time = np.linspace(0, 4000, 40001)
    values = np.where(time < 400, 100.0, 5.0 + 2.0 * np.sin(2 * np.pi * 0.1 * time))
    statistics = Result(time, {"surge": values}, {"surge": "m"}).statistics(discard=400)
    row = statistics["surge"]
    assert (row.unit, statistics.first) == ("m", 400.0)
    assert row.mean == pytest.approx(5.0, abs=1e-3)
    assert row.std == pytest.approx(np.sqrt(2), rel=1e-4)
    assert row.rms == pytest.approx(np.sqrt(27), rel=1e-4)
    assert (row.min, row.max) == (pytest.approx(3.0), pytest.approx(7.0))
    assert statistics.to_pandas().loc["surge", "max"] == row.max


def test_statistics_weigh_uneven_steps_by_time():
    time = np.array([0.0, 1.0, 1.1, 1.2, 1.3, 2.0])
    assert Result(time, {"x": time}).statistics()["x"].mean == pytest.approx(1.0)


def test_statistics_of_nothing():
    with pytest.raises(ModelError) as caught:
        result_from().statistics(discard=400)
    assert str(caught.value) == (
        "statistics: discarding 400 s leaves nothing of a result of 10 s. Discard less, or simulate longer."
    )


def test_short_text():
    lines = repr(result_from()).splitlines()
    assert lines[0] == "<Result of a pendulum: 0 s to 10 s, 101 points; finished.>"
    assert lines[1].split() == ["name", "unit", "mean", "std", "min", "max"]
    assert lines[2].split()[:2] == ["surge", "m"]


def test_netcdf_comes_back_whole(tmp_path):
    before = result_from()
    after = Result.open(before.save(tmp_path / "r.nc"))
    assert after.names == before.names
    assert after.attributes == before.attributes
    for name in before:
        xarray.testing.assert_identical(after[name], before[name])
    for key in ("time", "x", "z", "d"):
        np.testing.assert_array_equal(getattr(after.raw, key), getattr(before.raw, key))
    final, expected = after.final, before.final
    assert (final.time, final.x, final.z, final.d) == (expected.time, expected.x, expected.z, expected.d)
    assert final.parameter_hash == parameter_hash(PARAMETERS)


def test_netcdf_is_read_by_anyone(tmp_path):
    with xarray.open_dataset(result_from().save(tmp_path / "r.nc")) as dataset:
        assert dataset["surge"].attrs["units"] == "m"
        assert dataset.attrs["solver"] == "idas"


def test_an_opened_result_observes_with_its_model(tmp_path):
    class Plant:
        def observer(self, raw, parameters):
            assert parameters == PARAMETERS
            return Observer(lambda names: raw.x[:, [raw.x_names.index(name) for name in names]], names=raw.x_names)

    path = result_from().save(tmp_path / "r.nc")
    np.testing.assert_array_equal(Result.open(path, plant=Plant())["body.v"], np.cos(result_from().time))


def test_csv_header_carries_the_units(tmp_path):
    path = result_from().save(tmp_path / "r.csv")
    header = 'time [s],surge [m],line.force[0] [N],line.force[1] [N],line.force[2] [N],"turns[0,0] [-]"'
    assert path.read_text().splitlines()[0].startswith(header)
    back = Result.open(path)
    assert back.unit("surge") == "m" and back.unit("turns[0,0]") == "1"
    np.testing.assert_allclose(back.array("surge"), result_from().array("surge"), atol=1e-10)
    with pytest.raises(SimulationError) as caught:
        _ = back.final
    assert (
        str(caught.value)
        == "this result holds nothing to resume from (only .nc files do): save the first run as .nc."
    )


def test_no_half_file_is_left(tmp_path):
    path = result_from().save(tmp_path / "r.nc")
    whole = path.read_bytes()
    broken = result_from()
    broken.attributes["note"] = "\ud800"  # cannot be encoded: writing fails in the middle
    with pytest.raises(UnicodeEncodeError):
        broken.save(path)
    assert path.read_bytes() == whole
    assert [file.name for file in tmp_path.iterdir()] == ["r.nc"]


def test_file_errors(tmp_path):
    def message(action) -> str:
        with pytest.raises(ModelError) as caught:
            action()
        return str(caught.value).replace(str(tmp_path), "TMP")

    result = result_from()
    assert message(lambda: result.save(tmp_path / "r.xls")) == (
        "TMP/r.xls: a result is saved as .nc (netCDF), .csv or .outb (OpenFAST), not as '.xls'."
    )
    assert message(lambda: result.save(tmp_path / "no" / "r.nc")) == (
        "TMP/no/r.nc: the folder TMP/no does not exist. Make it first, or choose another one."
    )
    assert message(lambda: Result.open(tmp_path / "r.nc")) == "TMP/r.nc: there is no such file."
    (tmp_path / "r.nc").write_bytes(b"no result at all")
    assert message(lambda: Result.open(tmp_path / "r.nc")) == (
        "TMP/r.nc: is not a netCDF file that can be read, or it is damaged."
    )
    xarray.Dataset({"a": 1.0}).to_netcdf(tmp_path / "other.nc", engine="scipy")
    assert message(lambda: Result.open(tmp_path / "other.nc")) == (
        "TMP/other.nc: is a netCDF file, but not a result of fowtlib (attribute format = 'fowtlib result 1')."
    )
    for text in ("t,surge\n0,1\n", "case,state\nu8,done\n"):
        (tmp_path / "r.csv").write_text(text)
        told = message(lambda: Result.open(tmp_path / "r.csv"))
        assert told.startswith("TMP/r.csv:1: the header must read 'time [s]")
    head = "time [s],surge [m]\n0,1\n"
    for rows, wrong in (
        ("1,\n", "TMP/r.csv:3: '' is not a number."),
        ("1,2\n2,high\n", "TMP/r.csv:4: 'high' is not a number."),
        ("1,2\n\n2,3,4\n", "TMP/r.csv:5: has 3 values, and the header names 2 columns."),
        ("1,2\n\n0.5,3\n", "TMP/r.csv:5: the time 0.5 s comes after 1 s."),
        ("nan,2\n2,3\n", "TMP/r.csv:3: the time is no number."),
    ):
        (tmp_path / "r.csv").write_text(head + rows)
        assert message(lambda: Result.open(tmp_path / "r.csv")) == wrong
    (tmp_path / "r.csv").write_text("t,surge\n0,1\n")
    assert message(lambda: Result.open(tmp_path / "r.csv")) == (
        "TMP/r.csv:1: the header must read 'time [s],surge [m],...': one name and unit per column."
    )


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_a_csv_that_went_through_a_spreadsheet_is_read(tmp_path, encoding):
    path = tmp_path / "r.csv"
    path.write_bytes("time [s],surge [m]\r\n0,1\r\n0.5,2\r\n0.5,3\r\n".encode(encoding))
    read = Result.open(path)
    np.testing.assert_array_equal(read.time, [0, 0.5, 0.5])  # an event: before and after it
    np.testing.assert_array_equal(read["surge"], [1, 2, 3])


def test_two_columns_of_one_name_are_refused(tmp_path):
    (tmp_path / "r.csv").write_text("time [s],surge [m],surge [m]\n0,1,2\n")
    with pytest.raises(ModelError, match=r"r.csv:1: there are two columns 'surge'\."):
        Result.open(tmp_path / "r.csv")


def test_a_resumed_run_is_joined(tmp_path):
    path = result_from(0, 10, observe=True).save(tmp_path / "first.nc")
    first = Result.open(path)
    second = result_from(10, 20)
    whole = first.followed_by(second)
    np.testing.assert_allclose(whole.time, np.linspace(0, 20, 201))
    np.testing.assert_allclose(whole["surge"], np.sin(whole.time), atol=1e-12)
    assert whole.raw.x.shape == (201, 2) and whole.final.time == 20.0
    assert whole.unit("surge") == "m"


def test_joined_runs_observe_through_both_parts():
    whole = result_from(0, 10, observe=True).followed_by(result_from(10, 20, observe=True))
    np.testing.assert_allclose(whole["body.v"], np.cos(whole.time), atol=1e-12)


def test_runs_that_do_not_belong_together():
    first = result_from(0, 10)
    with pytest.raises(SimulationError) as caught:
        first.followed_by(result_from(5, 15))
    assert str(caught.value) == "these two results overlap: one ends at 10 s, the other begins at 5 s."
    with pytest.raises(SimulationError) as caught:
        first.check_resumable({**PARAMETERS, "body.mass": 3.0})
    assert str(caught.value) == (
        "the run to resume had other parameters: body.mass was 2.5, is 3.0. "
        "Give the same parameters, or start a new run."
    )
    first.check_resumable(PARAMETERS)


def _saved(tmp_path):
    return result_from(0, 10, observe=True).save(tmp_path / "r.nc")


def _damage(path, name):
    """Turn a bit in the middle of the numbers of a variable."""
    from scipy.io import netcdf_file

    with netcdf_file(path, "r", mmap=False) as file:
        numbers = file.variables[name].data.tobytes()
    data = bytearray(path.read_bytes())
    data[data.index(numbers) + len(numbers) // 2] ^= 4
    path.write_bytes(data)


def test_of_a_damaged_result_the_sound_series_are_read_when_asked(tmp_path):
    path = _saved(tmp_path)
    good = Result.open(path)
    _damage(path, "surge")
    with pytest.raises(ModelError, match=r"r.nc: the file is damaged: the numbers or the attributes of surge are not"):
        Result.open(path)
    with pytest.warns(UserWarning, match=r"r.nc: the file is damaged; read without surge\."):
        result = Result.open(path, damaged=True)
    assert "surge" not in result and set(result) == set(good) - {"surge"}
    for name in result:
        assert result.array(name).tobytes() == good.array(name).tobytes() and result.unit(name) == good.unit(name)
    assert result.raw.x.tobytes() == good.raw.x.tobytes()
    assert result.attributes["status"].endswith("Read from a damaged file, without surge.")


def test_damaged_states_are_not_gone_on_from(tmp_path):
    path = _saved(tmp_path)
    good = Result.open(path)
    _damage(path, "raw_x")
    with pytest.warns(UserWarning, match="read without raw_x; the states are lost"):
        result = Result.open(path, damaged=True)
    assert result.raw is None and set(result) == set(good)
    with pytest.raises(SimulationError, match="nothing to resume from"):
        result.final  # noqa: B018


def test_damaged_attributes_leave_the_series(tmp_path):
    path = _saved(tmp_path)
    good = Result.open(path)
    data = bytearray(path.read_bytes())
    data[data.index(b"fowtlib_version") + 24] ^= 1  # in the text; before it lie kind and length
    path.write_bytes(data)
    with pytest.warns(UserWarning, match="read without its attributes; the states are lost"):
        result = Result.open(path, damaged=True)
    assert set(result) == set(good) and result.raw is None and result.attributes["parameters"] == {}
    assert all(result.array(name).tobytes() == good.array(name).tobytes() for name in good)


def test_a_result_that_is_cut_off_is_read_up_to_there(tmp_path):
    path = _saved(tmp_path)
    good, data = Result.open(path), path.read_bytes()
    read = []
    for size in range(200, len(data), 97):
        path.write_bytes(data[:size])
        with pytest.raises(ModelError, match=str(path)):
            Result.open(path)
        try:
            with warnings.catch_warnings(record=True):
                result = Result.open(path, damaged=True)
        except ModelError as error:
            assert "damaged" in str(error)
            continue
        assert all(result.array(name).tobytes() == good.array(name).tobytes() for name in result)
        read.append(len(result))
    assert read and max(read) == len(good)


def test_a_sound_result_is_the_same_with_damaged(tmp_path):
    path = _saved(tmp_path)
    assert Result.open(path, damaged=True).attributes == Result.open(path).attributes
    (tmp_path / "n.nc").write_bytes(b"no result at all")
    with pytest.raises(ModelError, match="damaged at its beginning"):
        Result.open(tmp_path / "n.nc", damaged=True)
