"""How far results lie apart that were measured in other ways, for the summary."""

from typing import Any

from shapemorph.core.laws import LawSpread, Variant


def systematic_figures(spread_of_laws: LawSpread | None) -> dict[str, Any]:
    """Describe how far positions lie apart that were measured with several morph laws, mm."""
    if spread_of_laws is None or not (
        spread_of_laws.laws or spread_of_laws.failures or spread_of_laws.variants
    ):
        return {}
    columns = zip(
        spread_of_laws.laws,
        spread_of_laws.off_px.tolist(),
        spread_of_laws.compared.tolist(),
        spread_of_laws.rms.tolist(),
        spread_of_laws.p95.tolist(),
        strict=True,
    )
    names = ("law_off_px", "points_compared", "position_rms_mm", "position_p95_mm")
    laws = {law: dict(zip(names, figures, strict=True)) for law, *figures in columns}
    return {
        "systematic": {
            "main_law": spread_of_laws.laws[0] if spread_of_laws.laws else None,
            "position_rms_mm": _largest(
                [*spread_of_laws.rms.tolist(), *(v.rms for v in spread_of_laws.variants)]
            ),
            "position_p95_mm": _largest(
                [*spread_of_laws.p95.tolist(), *(v.p95 for v in spread_of_laws.variants)]
            ),
            "laws": laws,
            "variants": {each.name: _variant_figures(each) for each in spread_of_laws.variants},
            "failures": dict(spread_of_laws.failures),
        }
    }


def _variant_figures(variant: Variant) -> dict[str, Any]:
    return {
        "points_compared": variant.compared,
        "position_rms_mm": variant.rms,
        "position_p95_mm": variant.p95,
        "E1_rms": variant.e1_rms,
        "E2_rms": variant.e2_rms,
    }


def _largest(values: list[float]) -> float:
    return max(values, default=float("nan"))
