"""Knee files: what they carry, and what is refused."""

import numpy as np
import pytest

from kneecore import NAMES, FileFormatError, ParameterSpace, dump_knee, packaged_knee, read_knee
from kneecore._assets import asset_path
from kneecore.knee.file import parse_knee

TEXT = asset_path("baseline.toml").read_text(encoding="utf-8")


def test_the_packaged_file_says_that_it_is_a_reconstruction():
    assert "reconstruction" in packaged_knee().note
    assert "reconstruction" in ParameterSpace().note


def test_the_packaged_file_gives_the_default_space():
    space = ParameterSpace.from_file(asset_path("baseline.toml"))
    np.testing.assert_array_equal(space.lower, ParameterSpace().lower)
    np.testing.assert_array_equal(space.upper, ParameterSpace().upper)


@pytest.mark.parametrize("seed", range(20))
def test_writing_and_reading_changes_no_bit(tmp_path, seed):
    rng = np.random.default_rng(seed)
    knee = packaged_knee()
    baseline = knee.baseline * (1.0 + 0.01 * rng.random(28))
    current = knee.baseline * (1.0 + 0.01 * rng.random(28))
    text = dump_knee(baseline=baseline, half_ranges=knee.half_ranges, current=current, title="é")
    path = tmp_path / "knee.toml"
    path.write_text(text, encoding="utf-8")
    again = read_knee(path)
    np.testing.assert_array_equal(again.baseline, baseline)
    np.testing.assert_array_equal(again.current, current)
    np.testing.assert_array_equal(again.half_ranges, knee.half_ranges)
    assert again.title == "é"


def test_other_units_of_the_same_kind_are_read():
    radius = 'value = 32.1\nunit = "mm"\nhalf_range = 1.0'
    text = TEXT.replace(radius, 'value = 0.0321\nunit = "m"\nhalf_range = 0.001')
    text = text.replace('value = 24.0\nunit = "MPa"', 'value = 24e6\nunit = "Pa"')
    assert text != TEXT
    knee = parse_knee(text)
    np.testing.assert_allclose(knee.baseline, packaged_knee().baseline, rtol=1e-12)
    assert knee.half_ranges[NAMES.index("condyle_radius")] == pytest.approx(1e-3)


def test_a_current_knee_may_name_a_few_parameters():
    knee = parse_knee(TEXT + "\n[current]\ncondyle_radius = 33.0\n")
    moved = knee.current != knee.baseline
    assert [n for n, m in zip(NAMES, moved, strict=True) if m] == ["condyle_radius"]
    assert knee.current[NAMES.index("condyle_radius")] == pytest.approx(0.033)


def test_a_space_of_a_file_keeps_its_half_ranges_unless_a_bound_is_given(tmp_path):
    path = tmp_path / "knee.toml"
    path.write_text(TEXT.replace("half_range = 1.0", "half_range = 0.5", 1), encoding="utf-8")
    width = 1e3 * (lambda s: s.upper - s.lower)(ParameterSpace.from_file(path))
    assert width[0] == pytest.approx(1.0)
    assert width[1] == pytest.approx(2.0)
    given = ParameterSpace.from_file(path, geometry_bound_mm=0.25)
    assert 1e3 * (given.upper - given.lower)[0] == pytest.approx(0.5)
    assert np.degrees(given.upper - given.lower)[21] == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            'schema = "kneecore.knee/1"',
            'schema = "kneecore.knee/9"',
            "`schema` is 'kneecore.knee/9'",
        ),
        ('title = "Packaged baseline"', 'titel = "x"', "unknown key 'titel'"),
        ("[parameters.acl_femur_x]", "[parameters.acl_femur_z]", "unknown key 'acl_femur_z'"),
        ('unit = "deg"', 'unit = "mm"', r"`parameters.plateau_slope.unit`: unit 'mm' is not known"),
        ('unit = "deg"', 'unit = "grad"', "unit 'grad' is not known here; allowed: deg, rad"),
        ("value = -14.0", "value = nan", "`parameters.acl_femur_x.value` is nan"),
        ("value = -14.0", 'value = "-14"', "a finite number is allowed"),
        ("value = -14.0\n", "", "lacks the key 'value'"),
        ("value = 0.46", "value = 0.5", "`poissons_ratio` is 0.5"),
        ("value = 35.0", "value = -35.0", "`acl_stiffness` is -35 N/mm"),
        ("value = 32.1", "value = 0.0", "`condyle_radius` is 0 mm"),
        ("half_range = 1.0", "half_range = -1.0", "half_range` is -1"),
        (
            "half_range = 1.0",
            "half_range = 27000.0",
            r"`parameters.acl_femur_x.half_range` is 27000 mm; at most 500 mm is allowed \(which u",
        ),
        (
            'half_range_unit = "%"\nsource',
            'half_range_unit = "m"\nsource',
            "half_range_unit` is 'm'",
        ),
        ("value = -14.0", "value = = 1", "not a TOML file"),
        ("value = -14.0", "value = 1" + 400 * "0", "a finite number is allowed"),
        ("value = -14.0", "value = 1" + 5000 * "0", "not a TOML file"),
        ("value = -14.0", "value = " + 5000 * "[", "brackets are nested 5,001 deep"),
    ],
)
def test_what_is_not_allowed_is_named(old, new, said, tmp_path):
    assert old in TEXT
    path = tmp_path / "knee.toml"
    path.write_text(TEXT.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(FileFormatError, match=said) as caught:
        read_knee(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_parameter_is_named():
    start, end = TEXT.index("[parameters.acl_femur_x]"), TEXT.index("[parameters.acl_femur_y]")
    with pytest.raises(FileFormatError, match="lacks 'acl_femur_x'; all 28 are needed"):
        parse_knee(TEXT[:start] + TEXT[end:])


def test_an_unknown_parameter_in_the_current_knee_is_named():
    with pytest.raises(FileFormatError, match="`current` has the unknown key 'patella'"):
        parse_knee(TEXT + "\n[current]\npatella = 1.0\n")


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(FileFormatError, match="cannot be read"):
        read_knee(tmp_path / "none.toml")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FileFormatError, match="UTF-8"):
        read_knee(tmp_path / "binary.toml")
    (tmp_path / "large.toml").write_bytes(b"#" * 1_000_001)
    with pytest.raises(FileFormatError, match="larger than"):
        read_knee(tmp_path / "large.toml")
