from shapemorph.api import Result as Result
from shapemorph.api import facet_strain as facet_strain
from shapemorph.api import load as load
from shapemorph.api import measure as measure

__version__: str
