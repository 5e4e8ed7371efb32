"""Pages: one environment for the templates of all, and what their tables share."""

from collections.abc import Mapping
from importlib.resources import files
from typing import Any

from markupsafe import Markup

_PACKAGE, _FOLDER = "shapemorph.view", "templates"


def page(template: str, **values: Any) -> str:
    """Fill a template; what it shows is escaped, and a value that it misses is an error.

    Parameters
    ----------
    template : str
        Name of a file in ``view/templates``; those of plain pages extend ``page.html.j2``,
        which holds their head and look.
    **values
        What the template names.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    loader = PackageLoader(_PACKAGE, _FOLDER)
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined)
    return environment.get_template(template).render(values)


def asset(name: str) -> Markup:
    """Text of a file beside the templates, which goes into a page as it is."""
    return Markup((files(_PACKAGE) / _FOLDER / name).read_text(encoding="utf-8"))


def plain_page(template: str, **values: Any) -> str:
    """Fill a template that extends ``page.html.j2``: a page of tables, figures beside it."""
    import shapemorph

    return page(template, style=asset("page.css"), version=shapemorph.__version__, **values)


def mean_and_spread(figures: Mapping[str, float]) -> str:
    """Write ``mean`` and ``std`` as "0.0012 ± 0.0034", in one line."""
    return f"{figures['mean']:.4f}\N{NO-BREAK SPACE}±\N{NO-BREAK SPACE}{figures['std']:.4f}"
