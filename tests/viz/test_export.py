import io
import json
import re
from dataclasses import replace

import models
import numpy as np
import pytest
from PIL import Image
from searches import searched
from viz.visits import press, search_anew

from kneecore import Cancelled, ParameterSpace, SearchSettings, worst_case
from kneeviz.export import NAMES, __main__, chart, content, drawing, film
from kneeviz.export.page import html_page
from kneeviz.geometry.bones import bones
from kneeviz.geometry.mechanism import to_femur


@pytest.fixture(scope="module")
def result():
    return searched(pop_size=20, n_generations=3)


@pytest.fixture(scope="module")
def folder(result, tmp_path_factory):
    place = tmp_path_factory.mktemp("result")
    result.save(place, figures=False)
    return place


@pytest.fixture(scope="module")
def short(result):
    return film.film_of(result, frames=5)


def embedded(html):
    return json.loads(re.search(r'<script id="film".*?>(.*?)</script>', html)[1])


def made(kind, result, **options):
    return content(kind, result, **({"position": 0.0, "callback": None} | options))


def test_the_film_ends_at_the_models_angles(result, short):
    assert [knee.name for knee in short.knees] == ["baseline", "model_1", "model_2"]
    assert short.moment[[0, -1]].tolist() == [5.0, -5.0]
    for knee in short.knees:
        angles = np.degrees(result.responses[knee.name].flexion)
        np.testing.assert_allclose(knee.angle_deg[[0, -1]], angles[[5, 11]], atol=1e-9)


def placed(knee, k, points):
    """What a browser makes of ``translate(x y) rotate(angle)``, with y down."""
    angle = np.radians(knee["angle"][k])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return points @ turn.T + knee["tibia"][k]


def test_the_page_puts_bones_and_ligaments_where_the_model_has_them(short):
    tibia = next(bone for bone in bones() if bone.name == "tibia")
    flip = 1e3 * np.array([1.0, -1.0])
    for knee, told in zip(short.knees, drawing.frames(short)["knees"], strict=True):
        for k, pose in enumerate(knee.poses):
            there = to_femur(tibia.outline, pose.flexion, pose.tibia_position) * flip
            np.testing.assert_allclose(placed(told, k, tibia.outline * flip), there, atol=0.02)
            tibial = to_femur(
                knee.sweep.x[:16].reshape(4, 2, 2)[:, 1], pose.flexion, pose.tibia_position
            )
            ends = np.array(told["ends"][k]).reshape(4, 2, 2)[:, 1]
            np.testing.assert_allclose(ends, tibial * flip, atol=0.006)


def test_every_frame_is_inside_of_the_picture(short):
    left, right, bottom, top = short.window_mm()
    for knee in short.knees:
        assert (knee.ligaments_mm > [left, bottom]).all()
        assert (knee.ligaments_mm < [right, top]).all()


def test_the_chart_has_each_curve_and_dot_once(short):
    svg = chart.chart(short)
    for name in ("baseline", "model_1", "model_2"):
        assert svg.count(f"curve {name}") == svg.count(f"dot {name}") == 1
    across, up = chart.scales(short)
    assert across(across.low) == across.start
    assert up(up.high) == up.end


def test_the_page_needs_nothing_else_and_says_both_values_of_f(result):
    html = html_page(result)
    assert len(html) < 2e6
    assert not re.findall(r"""(?:src|href)=["'](?!data:)|url\(|@import""", html)
    assert "default-src 'none'" in html
    assert f"{result.objective_model:.2f}°" in html
    assert f"{result.objective_surrogate:.2f}°" in html
    assert "reconstruction" in html
    assert html == html_page(result)


def test_a_title_from_a_file_is_text():
    space = ParameterSpace(title="</script><script>alert(1)</script>")
    html = html_page(searched(space, pop_size=20, n_generations=3))
    assert "alert(1)" in html
    assert html.count("<script") == html.count("</script>") == 2


def test_knees_for_which_the_model_failed_are_left_out(result):
    failed = replace(result.responses["model_2"], refinements=-1)
    shown = replace(result, responses={**result.responses, "model_2": failed})
    kept = film.film_of(shown, frames=5)
    assert [knee.name for knee in kept.knees] == ["baseline", "model_1"]
    assert len(embedded(html_page(shown))["knees"]) == 2
    gone = {name: replace(r, refinements=-1) for name, r in result.responses.items()}
    nothing = replace(result, responses=gone)
    assert "<script" not in html_page(nothing)
    with pytest.raises(ValueError, match="the model failed for all knees"):
        made("png", nothing)


def test_another_models_page_has_its_figures_and_no_motion():
    other = worst_case(models.ishigami(), SearchSettings(pop_size=20, n_generations=3))
    html = made("html", other).decode()
    assert html.count("<img") == len(other.figures())
    assert "<script" not in html
    with pytest.raises(ValueError, match=r"which has no motion; a page \(html\) is allowed"):
        made("gif", other)


def test_the_animation_goes_there_and_back(result, monkeypatch):
    monkeypatch.setattr("kneeviz.export.files.film_of", lambda r: film.film_of(r, frames=4))
    told = []
    moving = made("gif", result, callback=told.append)
    with Image.open(io.BytesIO(moving)) as image:
        assert image.n_frames == 6
        assert image.info["loop"] == 0
    assert [report.done for report in told] == [0, 1, 2, 3]
    assert moving == made("gif", result)
    with pytest.raises(Cancelled):
        made("gif", result, callback=lambda report: True)


def test_a_picture_shows_its_position(result):
    start, end = made("png", result), made("png", result, position=1.0)
    assert start != end
    with Image.open(io.BytesIO(start)) as image:
        assert image.size == (1920, 1000)


def test_the_command_writes_what_is_asked_for(folder, result, tmp_path, capsys):
    names = [str(tmp_path / f"a.{kind}") for kind in ("html", "png")]
    arguments = [str(folder), "--html", names[0], "--png", names[1], "--quiet"]
    assert __main__.main(arguments) == 0
    said = capsys.readouterr()
    assert (said.out.split(), said.err) == (names, "")
    assert (tmp_path / "a.html").read_bytes() == made("html", result)
    assert __main__.main(arguments) == 2
    assert "is there already" in capsys.readouterr().err
    assert __main__.main([*arguments, "--force"]) == 0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "nothing is asked for; --html FILE, --gif FILE, --png FILE or --lesson FILE is"),
        (["--html", "a", "--gif", "./a"], "two of the files have the same name"),
        (["--html", ""], "`--html` is '.'; the name of a file is allowed"),
        (["--png", "a", "--position", "nan"], "`--position` is nan; 0 to 1 is allowed"),
        (["--png", "no/a"], "'no' is no folder"),
    ],
)
def test_what_is_not_allowed_is_one_line(folder, arguments, said, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert __main__.main([str(folder), *arguments]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert list(tmp_path.iterdir()) == []


def test_a_page_needs_a_result_and_the_lesson_none(tmp_path, capsys, monkeypatch):
    assert __main__.main(["--html", str(tmp_path / "a.html")]) == 2
    assert "`RESULT` is not given" in capsys.readouterr().err
    monkeypatch.setattr("kneeviz.export.files.html_sheet", lambda told: "the sheet")
    assert __main__.main(["--lesson", str(tmp_path / "a.html")]) == 0
    assert (tmp_path / "a.html").read_text() == "the sheet"


def test_a_result_that_is_none_is_one_line(tmp_path, capsys):
    assert __main__.main([str(tmp_path), "--html", str(tmp_path / "a.html")]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_a_visitor_takes_a_page_and_a_picture_with_him(page, visitor):
    search_anew(page, visitor)
    for name in ("knees.html", "knees.png"):
        press(visitor, page.view.files.result[name])
        visitor.wait(lambda c, n=name: len(c.downloads.get(n, b"")) > 10_000, 60)
    assert visitor.downloads["knees.html"] == made(NAMES["knees.html"], page.state.result)
    assert visitor.notifications == []
