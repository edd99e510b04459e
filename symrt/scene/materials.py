"""The material: models of reflection, and numbers for their parameters (before step 1)."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

from symrt.errors import refuse, shown, suggestion
from symrt.scene.checks import check_name, check_number, settle
from symrt.scene.media import HIGHEST_INDEX, LOWEST_INDEX, Dispersion, dispersion, dispersion_faults
from symrt.symbols import named

if TYPE_CHECKING:
    from symrt.reflection.models import Model


@dataclass(frozen=True, init=False)
class Material:
    """A named way of reflecting light: its spectra stay symbols, ``red.diffuse``, its parameters are numbers.

    Parameters
    ----------
    name
        The name by which shapes, textures and palettes refer to it.
    model
        The name of a model, a user's own `Model`, or several of these, stacked.
    glass, sellmeier, cauchy
        In the place of ``index``, an index that changes with the wavelength: of a glass by its name, see `glasses`, by
        Sellmeier's pairs ``[[B, C], …]``, or by Cauchy's numbers ``[A₀, A₁, …]``; λ in µm.
    **parameters
        A number for each parameter of the model, such as ``exponent``.

    Examples
    --------
    >>> Material("brass", model=["phong_plain", "mirror"], exponent=60).symbols
    ('brass.diffuse', 'brass.mirror', 'brass.specular')
    >>> str(Material("prism", "glass", glass="N-SF11").dispersion)
    "glass = 'N-SF11'"
    """

    name: str
    model: "str | Model | tuple[str | Model, ...]"
    parameters: Mapping[str, float] = field(hash=False)
    dispersion: Dispersion | None

    def __init__(
        self,
        /,
        name: str,
        model: Any = "lambert",
        *,
        glass: Any = None,
        sellmeier: Any = None,
        cauchy: Any = None,
        **parameters: Any,
    ) -> None:
        settle(self, name=name, model=tuple(model) if isinstance(model, list | tuple) else model)
        refuse([*check_name("name", name), *_model_faults(self._models)])
        by_wavelength = (glass, sellmeier, cauchy)
        refuse(dispersion_faults(*by_wavelength, parameters.get("index"), self.reflection.refracts))
        settle(self, parameters=parameters, dispersion=dispersion(*by_wavelength))
        refuse([*_parameter_faults(self), *_inside_faults(self)])
        settle(self, parameters={key: float(value) for key, value in parameters.items()})

    @property
    def _models(self) -> "tuple[str | Model, ...]":
        return self.model if isinstance(self.model, tuple) else (self.model,)

    @cached_property
    def reflection(self) -> "Model":
        """The material's model, or all of its models stacked."""
        # SymPy is slow to import, and reading a scene's geometry does not need it.
        from symrt.reflection.models import MODELS, stack  # noqa: PLC0415

        models = [MODELS[model] if isinstance(model, str) else model for model in self._models]
        return models[0] if len(models) == 1 else stack(models)

    @property
    def symbols(self) -> tuple[str, ...]:
        """Names of the reflectances that a palette must give."""
        return tuple(named(self.name, component) for component in sorted(self.reflection.components))


def _model_faults(models: tuple[Any, ...]) -> Iterator[str]:
    from symrt.reflection.models import MODELS, Model  # noqa: PLC0415  as above

    if not models:
        yield "model = []: a material needs at least one model; write model = 'lambert'"
    for model in models:
        if isinstance(model, str) and model not in MODELS:
            yield f"model = {shown(model)}: no model has this name; {suggestion(model, MODELS)}"
        elif not isinstance(model, str | Model):
            yield f"model = {shown(model)}: a model is a name, a list of names, or an rt.Model; try 'lambert'"


def _parameter_faults(material: Material) -> Iterator[str]:
    # Parameters that are missing.
    needed = material.reflection.parameters
    given = {*material.parameters, "index"} if material.dispersion else set(material.parameters)
    for key in sorted(needed - given):
        example = "index = 1.5, or glass = 'N-BK7'" if key == "index" else f"{key} = 40, say"
        yield f"{key}: the model {models_text(material)} needs it; write {example}"

    # Those given: unknown ones, and values beyond what they may be.
    for key, value in material.parameters.items():
        faults = list(check_number(key, value))
        if key not in needed:
            rule = f"the model {models_text(material)} has no such parameter; {suggestion(key, needed)}"
            yield f"{key if key.isidentifier() else shown(key)}: {rule}"
        elif not faults and key == "exponent" and not 0 <= value <= 1e7:
            yield f"exponent = {shown(value)}: it must be from 0 to 1e7; 40 is glossy"
        elif (
            not faults
            and key == "index"
            and material.reflection.refracts
            and not LOWEST_INDEX <= value <= HIGHEST_INDEX
        ):
            rule = f"it must be from {LOWEST_INDEX:g} to {HIGHEST_INDEX:g}"
            yield f"index = {shown(value)}: {rule}; glass has 1.5, water 1.33"
        yield from faults


def _inside_faults(material: Material) -> Iterator[str]:
    model = material.reflection
    if model.inside != 0 and model.transmitted == 0:
        yield (
            f"model = {models_text(material)}: it absorbs light on its way through, and lets none in; stack it on "
            'glass, model = ["glass", "absorption"], index = 1.5'
        )


def models_text(material: Material) -> str:
    """The models of a material, in words."""
    return " + ".join(model if isinstance(model, str) else "of one's own" for model in material._models)  # noqa: SLF001  the same module
