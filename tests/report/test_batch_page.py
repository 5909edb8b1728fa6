"""The report of a batch: its numbers are those of the results, its links lead somewhere, and it needs no other file."""

from __future__ import annotations

import html
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from fowtlib.cases import Case, run_batch
from fowtlib.language.errors import ModelError, NotFoundError
from fowtlib.report import batch_page, sections, write_batch_page
from fowtlib.report.content import number
from fowtlib.report.view import View

SPEEDS, SEEDS = (8, 16), (1, 2)


class Page(HTMLParser):
    """What a page holds: names of places, links, texts of captions and of cells."""

    def __init__(self, text: str):
        super().__init__()
        self.ids: list[str] = []
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.captions: list[str] = []
        self._inside = ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        named = dict(attrs)
        self.ids += [named["id"]] if "id" in named else []
        self.links += [named["href"]] if tag == "a" else []
        self.loaded += [value for key, value in attrs if key in ("src", "data") or (tag == "link" and key == "href")]
        if tag == "figcaption":
            self.captions.append("")
            self._inside = tag

    def handle_endtag(self, tag):
        self._inside = "" if tag == self._inside else self._inside

    def handle_data(self, data):
        if self._inside:
            self.captions[-1] += data


@pytest.fixture(scope="module")
def batch(tmp_path_factory):
    cases = [
        Case(
            f"u{speed}_s{seed}", "oc3_spar_rigid",
            {"wind.kind": "kaimal", "wind.mean_speed": speed, "wind.seed": seed, "sea.seed": seed},
            duration=40.0, discard=10.0, solver="fixed", group="DLC 1.2", safety_factor=1.35,
            labels={"wind_speed": speed, "seed": seed},
        )
        for speed in SPEEDS for seed in SEEDS
    ]  # fmt: skip
    folder = tmp_path_factory.mktemp("batch")
    return run_batch([*cases, ending(folder)], folder / "b", workers=1)


def ending(folder):
    """A case of a wind of which nothing is known after 3 s."""
    (folder / "wind.csv").write_text("time [s],u [m/s]\n0,8\n1,9\n2,8\n3,9\n")
    wind = {"wind.kind": "file", "wind.file": str(folder / "wind.csv")}
    return Case("wrong", "oc3_spar_rigid", wind, start="file", duration=6.0, labels={"wind_speed": 8, "seed": 1})


@pytest.fixture(scope="module")
def text(batch):
    return batch_page(batch, title="Spar <in> storms", command="fowt batch report cases.yaml")


@pytest.fixture(scope="module")
def page(text):
    return Page(text)


def test_every_link_leads_to_one_place_and_nothing_comes_from_elsewhere(page, text):
    assert page.links and all(link.startswith("#") for link in page.links)
    assert {link[1:] for link in page.links} <= set(page.ids)
    assert len(page.ids) == len(set(page.ids))
    assert not page.loaded and "@import" not in text
    assert not re.search(r"url\((?!#)", text)


def test_the_worst_case_is_one_click_away(batch, page, text):
    values = {row.name: batch.result(row.name).array("pitch") for row in batch.rows("done")}
    worst = max(values, key=lambda name: values[name].max())
    assert "#worst-pitch" in page.links and f"#case-{worst}" in page.links
    middle = np.mean([series.mean() for series in values.values()])
    high, low = max(map(np.max, values.values())), min(map(np.min, values.values()))
    told = high if high - middle > middle - low else low
    assert any("pitch" in caption and f"value {number(told)} deg at" in caption for caption in page.captions)


def test_operating_curves_tell_the_mean_of_the_seeds(batch, page):
    means = {speed: np.mean([batch.result(f"u{speed}_s{seed}").array("rotor_speed").mean() for seed in SEEDS])
             for speed in SPEEDS}  # fmt: skip
    top = max(means, key=means.__getitem__)
    assert any(f"rotor speed: the mean over cases is largest at wind speed {top}, {number(means[top])} rpm" in caption
               for caption in page.captions)  # fmt: skip


def test_every_figure_has_its_number_and_its_sentence(page):
    assert len(page.captions) > 20
    numbers = [caption.split(".")[0] for caption in page.captions]
    assert numbers == [f"Figure {k + 1}" for k in range(len(numbers))]
    assert all(caption.endswith(".") and any(letter.isdigit() for letter in caption[12:]) for caption in page.captions)


def test_loads_are_told_with_their_weights_and_factors(batch, text):
    loads = [batch.statistics(f"u{speed}_s{seed}")["equivalent_loads"]["fairlead_tension_1"]["4"]
             for speed in SPEEDS for seed in SEEDS]  # fmt: skip
    assert f"<td>{number(float(np.mean(np.power(loads, 4)) ** 0.25))}</td>" in text
    highest = max(batch.result(row.name).array("thrust").max() for row in batch.rows("done"))
    assert "thrust max" in text and f"<td>{number(1.35 * highest)}</td>" in text


def test_cases_that_stand_for_no_time_do_not_count_for_the_life(batch, monkeypatch):
    rows = [replace(row, case=replace(row.case, weight=0.3 if row.name == "u8_s1" else 0.0)) for row in batch.rows()]
    monkeypatch.setattr(batch, "rows", lambda *_: rows)
    table = sections.fatigue(View(batch, [])).tables[0]
    row = next(row for row in table.rows if row[0] == "thrust" and row[2] == 4.0)
    alone = batch.statistics("u8_s1")["equivalent_loads"]["thrust"]["4"]
    assert row[3] == pytest.approx(0.3**0.25 * alone) and len(row) == len(table.heads)


def test_failures_are_told_in_their_own_words_and_texts_are_only_texts(batch, text):
    assert "wind.csv" in batch.row("wrong").message and "Failures and warnings" in text
    assert batch.row("wrong").message in html.unescape(text)
    assert "Spar &lt;in&gt; storms" in text and "<in>" not in text


def test_provenance_names_versions_files_and_the_command(batch, text):
    from importlib.metadata import version

    assert f"casadi {version('casadi')}" in text and "fowt batch report cases.yaml" in text
    path, digest = next(iter(batch.rows()[0].files.items()))
    assert path in text and digest in text


def test_what_cannot_be_reported_is_said(batch, tmp_path):
    with pytest.raises(NotFoundError, match="no result 'pich'.*pitch"):
        batch_page(batch, channels=["pich"])
    nothing = run_batch([ending(tmp_path)], tmp_path / "n", workers=1)
    with pytest.raises(ModelError, match="no case is done, so there is nothing to report"):
        batch_page(nothing)
    path = write_batch_page(batch, tmp_path / "page.html", channels=["surge"])
    assert "worst-surge" in path.read_text() and "worst-pitch" not in path.read_text()
