"""The options that choose the knees: the same on every command line."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

if TYPE_CHECKING:
    from kneecore.knee.model import Knee
    from kneecore.knee.space import ParameterSpace

Millimetres = Annotated[float | None, tyro.conf.arg(metavar="MM")]
Degrees = Annotated[float | None, tyro.conf.arg(metavar="DEG")]
Percent = Annotated[float | None, tyro.conf.arg(metavar="PERCENT")]
File = Annotated[str | None, tyro.conf.arg(metavar="FILE")]
Folder = Annotated[str | None, tyro.conf.arg(metavar="DIR")]
Number = Annotated[float | None, tyro.conf.arg(metavar="NUMBER")]
Count = Annotated[int | None, tyro.conf.arg(metavar="N")]


@dataclass(frozen=True, kw_only=True)
class SpaceOptions:
    """Which knees are possible."""

    case: Literal["both", "geometry", "material"] = "both"
    """Which parameters vary: all 28, the 22 geometric or the 6 of the material."""
    geometry_bound_mm: Millimetres = None
    """Half-range of every length and coordinate, mm. Unset: the baseline's, 1 mm."""
    slope_bound_deg: Degrees = None
    """Half-range of the plateau's slope, deg. Unset: the baseline's, 1 deg."""
    material_bound_percent: Percent = None
    """Half-range of the material parameters, per cent. Unset: the baseline's, 10 %."""
    rest_length_bound_mm: Millimetres = None
    """Half-range of the ligaments' rest lengths, mm: four more uncertain parameters, in every case.
    Unset: the knee file's, and none in the packaged baseline."""
    rest_length_bound_percent: Percent = None
    """The same in per cent of the baseline's rest lengths; give one of the two."""
    distribution: Literal["uniform", "normal", "truncated-normal", "triangular"] | None = None
    """How knees are drawn for sampling and influence: uniformly within the bounds; normally, with
    the bounds --deviations standard deviations from the mean; the same cut off at the bounds; or
    triangular, with the peak at the centre. Unset: the knee file's, uniform in the packaged
    baseline."""
    deviations: Number = None
    """How many standard deviations of a normal or truncated normal distribution the half-ranges
    are. Unset: the knee file's, or 3: the bounds hold 99.7 % of the knees."""
    baseline: File = None
    """A knee file (TOML) of your own: values, units, half-ranges, sources."""
    around: Literal["baseline", "current"] = "baseline"
    """The knee in the middle of the bounds: the file's baseline, or its current knee."""

    def space_of_knees(self) -> "ParameterSpace":
        """Return the space; raises what `ParameterSpace` and `ParameterSpace.from_file` raise."""
        from kneecore.errors import ParameterError
        from kneecore.knee.space import ParameterSpace

        given = {
            name: value
            for name in (
                "geometry_bound_mm",
                "slope_bound_deg",
                "material_bound_percent",
                "rest_length_bound_mm",
                "rest_length_bound_percent",
                "distribution",
                "deviations",
            )
            if (value := getattr(self, name)) is not None
        }
        if self.baseline is not None:
            return ParameterSpace.from_file(
                self.baseline, case=self.case, around=self.around, **given
            )
        if self.around != "baseline":
            raise ParameterError(
                f"`around` is {self.around!r}; it needs a `baseline` file with a current knee"
            )
        return ParameterSpace(case=self.case, **given)


@dataclass(frozen=True, kw_only=True)
class KneeOptions(SpaceOptions):
    """Which knees are possible, and how they are computed."""

    rest_length: Literal["recomputed", "fixed"] = "recomputed"
    """Ligaments strain-free in each knee's own load-free pose, or as long as the baseline's."""
    solver: Literal["dynamics", "equilibrium"] = "dynamics"
    """The response of the true model: its motion over 23 s, or the knee at rest under each load."""
    threads: Count = None
    """Threads for the true model. Unset: all cores."""

    def knee(self) -> "Knee":
        """Return the knees; raises what `kneecore.Knee` and its space raise."""
        from kneecore.knee.model import Knee

        return Knee(
            self.space_of_knees(),
            solver=self.solver,
            rest_length=self.rest_length,
            threads=self.threads,
        )


@dataclass(frozen=True, kw_only=True)
class OutputOptions:
    """Where what was computed goes."""

    out: Folder = None
    """Write the result's files (JSON, CSV, figures as PNG and SVG) to this folder."""
    force: bool = False
    """Overwrite a result that is in the folder already."""
    resume: bool = False
    """Go on where a run with the same options and the same folder was stopped (by Ctrl-C, a crash,
    a full disk): to the same bytes. What it has kept is in the folder's checkpoint."""
    json: bool = False
    """Print the result as one JSON object and nothing else on stdout."""
    quiet: bool = False
    """Show no progress."""
