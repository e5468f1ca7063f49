"""How likely knees are: distributions of a space, its file, its results, its command lines."""

import json

import numpy as np
import pytest
from results import check_comes_back
from scipy import stats

import kneecore
from kneecore import (
    NAMES,
    FileFormatError,
    Knee,
    ParameterError,
    ParameterSpace,
    SamplingSettings,
    SearchSettings,
    monte_carlo,
    worst_case,
)
from kneecore.cli import search, uncertainty

NU = NAMES.index("poissons_ratio")
NORMAL = {"distribution": "normal", "deviations": 2}


@pytest.fixture(scope="module")
def found():
    """Return a small search of a quantile box, with knees at rest."""
    space = ParameterSpace(case="material", quantile=0.9, **NORMAL)
    knee = Knee(space, solver="equilibrium")
    return worst_case(knee, SearchSettings(training_samples=10, pop_size=30, n_generations=20))


@pytest.mark.parametrize(
    ("options", "one", "poisson"),
    [
        (NORMAL, stats.norm(0.0, 0.5e-3), stats.truncnorm(-np.inf, 39 / 23, 0.46, 0.023)),
        (
            {"distribution": "truncated-normal"},
            stats.truncnorm(-3, 3, scale=1e-3 / 3),
            stats.truncnorm(-3, 0.039 / (0.046 / 3), 0.46, 0.046 / 3),
        ),
        ({"distribution": "triangular"}, stats.triang(0.5, -1e-3, 2e-3), None),
    ],
)
def test_knees_are_drawn_as_scipy_says(options, one, poisson):
    knee = Knee(ParameterSpace(**options))
    chances = np.array([0.001, 0.2, 0.5, 0.8, 0.999])
    x = knee.drawn(np.repeat(chances[:, None], 28, axis=1))
    k = NAMES.index("pcl_tibia_y")
    np.testing.assert_allclose(x[:, k] - knee.nominal[k], one.ppf(chances), atol=1e-12)
    assert x[:, NU].max() <= 0.499
    if poisson is not None:  # its mean is the centre, although its upper bound is clipped
        np.testing.assert_allclose(x[:, NU], poisson.ppf(chances), rtol=1e-9)


def test_a_triangle_has_its_peak_at_the_centre():
    centre = ParameterSpace().baseline.copy()
    centre[0] += 5e-3
    knee = Knee(ParameterSpace(centre=centre, distribution="triangular"))
    assert (knee.inputs[0].nominal, knee.inputs[0].mode) == (knee.space.baseline[0], centre[0])


def test_a_quantile_box():
    space = ParameterSpace(quantile=0.9, **NORMAL)
    knee = Knee(space)
    np.testing.assert_array_equal([knee.lower, knee.upper], [space.lower, space.upper])
    half = 0.5 * (space.upper - space.lower)[0]
    assert half == pytest.approx(0.5e-3 * stats.norm.ppf(0.95))
    u = np.random.default_rng(0).random((5, 28))
    np.testing.assert_array_equal(knee.drawn(u), Knee(ParameterSpace(**NORMAL)).drawn(u))
    # Half the stated bounds, and the quantile box of these.
    narrower = knee.with_widths(np.full(28, 0.5)).space
    assert 0.5 * (narrower.upper - narrower.lower)[0] == pytest.approx(0.5 * half)
    assert narrower.likely == space.likely
    assert knee.with_quantile(None).space.upper[0] == space.baseline[0] + 1e-3


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"distribution": "log-normal"}, "`distribution` is 'log-normal'; 'uniform' or 'normal'"),
        ({"deviations": 2}, "`deviations` is 2; a uniform distribution has none"),
        ({"distribution": "normal", "deviations": 0}, "`deviations` is 0; above 0 is allowed"),
        ({"quantile": 1.0}, "`quantile` is 1; above 0 and below 1 is allowed"),
        ({"quantile": "0.9"}, "`quantile` is '0.9'; a finite number is allowed"),
    ],
)
def test_what_is_not_allowed(options, said):
    with pytest.raises(ParameterError) as error:
        ParameterSpace(**options)
    assert str(error.value).startswith(said)


def test_a_knee_file_says_how_likely_its_knees_are(tmp_path):
    path = tmp_path / "knee.toml"
    path.write_text(ParameterSpace(**NORMAL).to_toml())
    assert path.read_text().count('distribution = "normal"\ndeviations = 2.0\n') == 1
    assert "distribution" not in ParameterSpace().to_toml()
    assert ParameterSpace.from_file(path).likely == ("normal", 2.0, None)
    other = ParameterSpace.from_file(path, distribution="triangular", quantile=0.5)
    assert other.likely == ("triangular", None, 0.5)
    assert ParameterSpace.from_file(path, deviations=1).likely == ("normal", 1.0, None)
    path.write_text(path.read_text().replace('"normal"', '"beta"'))
    with pytest.raises(FileFormatError, match=r"knee\.toml: `distribution` is 'beta'; 'uniform'"):
        ParameterSpace.from_file(path)


def test_a_result_says_it_and_is_read_back(found):
    document = check_comes_back(found)
    told = {k: document["baseline"][k] for k in ("distribution", "deviations", "quantile")}
    assert told == NORMAL | {"quantile": 0.9}
    report = " ".join(str(found).split())
    assert "Bounds: the central 90 % of each distribution (normal with bounds at 2 sd)." in report
    document["baseline"]["distribution"] = "beta"
    with pytest.raises(FileFormatError, match="`distribution` is 'beta'"):
        kneecore.SearchResult.from_json(json.dumps(document))


def test_the_printed_command_gives_the_result_again(found, capsys):
    words = kneecore.command_line(found).split()[3:]
    assert {"--distribution", "--deviations", "--quantile"} <= set(words)
    assert search.main([*words, "--json", "--quiet"]) == 0
    again = json.loads(capsys.readouterr().out)
    told = json.loads(found.to_json())
    for key in ("seconds", "digest"):
        del told[key], again[key]
    assert again == told


def test_sampling_from_a_terminal(capsys):
    words = ["--case", "material", "--solver", "equilibrium", "--samples", "200", "--quiet"]
    options = ["--distribution", "normal", "--deviations", "2"]
    assert uncertainty.main([*words, *options]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "200 samples (independent, seed 0)" in told
    assert "Inputs: normal with bounds at 2 sd." in told
    assert uncertainty.main([*words, "--deviations", "2"]) == 2
    said = "`--deviations` is 2; a uniform distribution has none\n"
    assert capsys.readouterr().err.endswith(said)


def test_half_as_wide_a_distribution_is_half_as_wide_an_angle():
    """In small bounds the knee is linear: its angle's deviation goes with its parameters'."""
    how = SamplingSettings(n_samples=256, sampling="sobol")

    def sd(**options):
        space = ParameterSpace(geometry_bound_mm=0.02, case="geometry", **options)
        return monte_carlo(Knee(space, solver="equilibrium"), how).y.sd

    one, two = sd(distribution="normal", deviations=2), sd(distribution="normal", deviations=4)
    np.testing.assert_allclose(one, 2.0 * two, rtol=0.02)
    np.testing.assert_allclose(sd(), one * 2.0 / np.sqrt(3.0), rtol=0.1)
